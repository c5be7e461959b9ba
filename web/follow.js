// Which method runs follows from what the hand takes: the one that takes such an edit, and most of
// what has been edited before.

// The first of those that take as much; those with indirect light come first.
const ORDER = ["direct_to_indirect", "brdf_editing", "glossy_prt", "wavelet_brdf"];
const KINDS = { lights: "lights", environment: "environment", materialEdits: "materials", camera: "camera" };
const WORDS = { lights: "changed lights", environment: "a changed environment", materials: "changed materials" };

// Kinds of edit that there are by now.
function edited({ changed, environmentChanged, materialEdits }) {
  const kinds = {
    lights: changed, environment: environmentChanged, materials: Object.keys(materialEdits).length > 0,
  };
  return Object.keys(kinds).filter((kind) => kinds[kind]);
}

// Materials count where the method has all their types.
function shows({ edits, models }, kind, { materialEdits }) {
  if (!edits.includes(kind)) return false;
  return kind !== "materials" || Object.values(materialEdits).every(({ type }) => models.includes(type));
}

// As the service describes it; undefined where none takes such an edit.
export function methodFor(state, kind) {
  const kinds = edited(state);
  const merit = (method) => kinds.filter((each) => shows(method, each, state)).length;
  const rank = ({ name }) => ORDER.indexOf(name);
  return state.scene.methods
    .filter(({ edits }) => edits.includes(kind))
    .sort((a, b) => merit(b) - merit(a) || rank(a) - rank(b))[0];
}

// Types of material for a hand to choose, whichever method shows them now.
export const modelsFor = (state) =>
  state.takes("materials") ? state.models : (methodFor(state, "materials")?.models ?? []);

// Whether materials are edited by controls; else by a precompute for others, see `Materials`.
export const byHand = (state) => state.takes("materials") || !state.takes("camera");

// A free camera wants glossy transfer, where that carries all the light that there is: it leaves lamps
// out. Otherwise the method stays, and is precomputed for the new view.
function carriesAll({ lights, materialEdits }) {
  return !lights.some(({ enabled }) => enabled) && !Object.keys(materialEdits).length;
}

// To be listened to before whatever asks for frames.
export function follow(state) {
  state.listen((what, moving) => {
    const kind = KINDS[what];
    if (!kind || state.takes(kind)) return;
    const wanted = kind === "camera" ? moving && carriesAll(state) : edited(state).includes(kind);
    const method = wanted && methodFor(state, kind);
    if (method) state.setMethod(method.name);
  });
}

// What has been edited and the method does not show, in a sentence; null where it shows all.
export function leftOut(state) {
  const method = state.scene.methods.find(({ name }) => name === state.method);
  const missing = edited(state).filter((kind) => !shows(method, kind, state));
  if (!missing.length) return null;
  const words = missing.map((kind) => WORDS[kind]).join(" and ");
  return `Not shown now: ${words}. Take that in hand, or undo, to see it.`;
}
