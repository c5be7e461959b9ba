// The page: wires state, picture, handles, panels and the live socket together.

import { drawMethods } from "./choices.js";
import { Compare } from "./compare.js";
import { Detail } from "./detail.js";
import { EnvironmentPanel } from "./environment.js";
import { follow, leftOut } from "./follow.js";
import { Front } from "./front.js";
import { Handles } from "./handles.js";
import { History } from "./history.js";
import { Keep } from "./keep.js";
import { Keys } from "./keys.js";
import { LightList } from "./light_list.js";
import { Live } from "./live.js";
import { MaterialEditor } from "./material_editor.js";
import { Materials, post } from "./materials.js";
import { Orbit } from "./orbit.js";
import { Panel } from "./panel.js";
import { Picking } from "./picking.js";
import { Reference } from "./reference.js";
import { Requests } from "./requests.js";
import { Scenes, called } from "./scenes.js";
import { Snapshots } from "./snapshots.js";
import { State } from "./state.js";
import { Status, told } from "./status.js";
import { welcome } from "./welcome.js";

const find = (id) => document.getElementById(id);
const canvas = find("canvas");
const context = canvas.getContext("2d", { alpha: false });

const state = new State();
let live = null;

const status = new Status(find, async (job) => {
  const ended = job.status === "failed" || job.status === "cancelled";
  await (ended ? precompute() : call(`api/jobs/${job.id}`, { method: "DELETE" }));
});
const requests = new Requests(state, (edit, cause) => live?.send(edit, cause));
const list = new LightList(state, {
  list: find("lights"), tools: find("lights-tools"), filter: find("lights-filter"),
  count: find("lights-count"), several: find("several"),
});
const handles = new Handles(
  state,
  { picture: find("picture"), handles: find("handles"), lines: find("lines") },
  () => list.adding,
);
const panel = new Panel(state, { light: find("light"), add: find("add"), reset: find("reset") });
const environment = new EnvironmentPanel(
  state,
  {
    box: find("environment"), pad: find("pad"), map: find("environment-map"),
    file: find("map-file"), open: find("map-open"), reset: find("environment-reset"),
  },
  { picture: mapPicture, send: (file) => sendFile("maps", file) },
);
const materials = new Materials(
  state,
  { part: find("materials-part"), list: find("materials"), other: find("materials-by-hand") },
  { call, follow: (job) => status.asked(job), problem: (problem) => status.problem(problem) },
);
const editor = new MaterialEditor(
  state,
  {
    part: find("editor-part"), list: find("editor-list"), box: find("editor"),
    reset: find("editor-reset"),
  },
  { call, thumbnail, sendMeasured: (file) => sendFile("measured", file) },
);
const detail = new Detail(state, {
  part: find("distance-part"), far: find("distance"), farValue: find("distance-value"),
  near: find("near"), away: find("far"), detailPart: find("detail-part"), detail: find("detail"),
  levels: find("levels"), legend: find("legend"), hint: find("detail-hint"),
  alpha: find("alpha"), alphaPart: find("alpha-part"), alphaValue: find("alpha-value"),
});
const picking = new Picking(state, find("picture"), (x, y) => editor.pick(x, y));
const compare = new Compare(
  state, { button: find("compare"), canvas, before: find("before") }, ownPicture,
);
const front = new Front(state, find, {
  call,
  budget: (error) => status.setBudget(error),
  used: () => {
    canvas.dataset.state = "changing";
    requests.changed(false);
  },
});
const reference = new Reference(state, find, { call });
const keep = new Keep(state, find, { problem: (detail) => status.problem({ detail }) });
new Snapshots(state, find, keep);
new History(state, { undo: find("undo"), redo: find("redo") });
const scenes = new Scenes(find, { call, open });
follow(state);
const orbit = new Orbit(state, find("picture"), find("camera-mode"));
new Keys(
  state,
  { dialog: find("keys"), open: find("keys-open"), close: find("keys-close") },
  { handles, list },
);
welcome(find("welcome"), find("welcome-close"));
for (const button of document.querySelectorAll("[data-jump]")) {
  button.addEventListener("click", () => {
    const parts = button.dataset.jump.split(" ").map(find);
    parts.find((part) => !part.hidden)?.scrollIntoView({ block: "start" });
  });
}

state.listen((what, moving) => {
  for (const side of [list, panel, environment]) what === "scene" ? side.open() : side.draw();
  editor.draw();
  detail.draw();
  handles.draw();
  if (what === "scene" || what === "method") {
    materials.leave();
    editor.open();
    picking.draw();
    front.open();
    drawMethods(find("methods"), state, (name) => state.setMethod(name));
    orbit.setMode(state.takes("camera"));
  }
  status.note(leftOut(state));
  if (["scene", "method", "materials"].includes(what)) materials.refresh();
  if (["materialEdits", "restored"].includes(what) && !moving) editor.refit();
  find("camera-reset").disabled = !state.cameraMoved;
  if (what === "exposure") drawExposure();
  reference.changed(what, moving);
  if (what === "selected" || (what === "hand" && !state.takes("materials"))) return;
  canvas.dataset.state = "changing";
  requests.changed(moving, what === "camera" && !state.takes("camera"));
});

async function call(path, options = {}) {
  const response = await fetch(path, options);
  const body = response.status === 204 ? null : await response.json();
  if (!response.ok) {
    status.problem(body);
    throw new Error(told(body));
  }
  return body;
}

async function precompute() {
  const { camera } = state.edits();
  const job = await call(`api/scenes/${encodeURIComponent(state.scene.name)}/precompute`,
    post({ method: state.method, edits: camera ? { camera } : {} }));
  status.job(job);
  requests.changed(false);
}

async function picture(what, edits) {
  const path = `api/scenes/${encodeURIComponent(state.scene.name)}/${what}`;
  const request = post(edits);
  request.headers.Accept = "image/png";
  const response = await fetch(path, request);
  if (!response.ok) throw new Error((await response.json()).detail);
  return createImageBitmap(await response.blob());
}

function mapPicture(map) {
  // The scene's own map may be a file that nobody can ask for by name.
  const own = JSON.stringify(map) === JSON.stringify(state.scene.environment.description?.map);
  return picture("environment", own ? {} : { environment: { map } });
}

function ownPicture({ edits, exposure, method, settings: chosen }) {
  const settings = JSON.stringify(chosen);
  return picture(`frame?${new URLSearchParams({ exposure, method, settings })}`, edits);
}

async function thumbnail(material) {
  const query = new URLSearchParams({ material: JSON.stringify(material) });
  const path = `api/scenes/${encodeURIComponent(state.scene.name)}/materials/thumbnail?${query}`;
  const response = await fetch(path);
  if (!response.ok) throw new Error(told(await response.json()));
  return response.blob();
}

function sendFile(what, file) {
  const path = `api/${what}?name=${encodeURIComponent(file.name.slice(-200))}`;
  return call(path, { method: "POST", body: file });
}

function drawExposure() {
  const stops = state.exposure;
  find("exposure").value = stops;
  const words = `${stops > 0 ? "+" : ""}${stops.toFixed(1)} EV`;
  find("exposure-value").textContent = words;
  status.exposure(words);
}

// What the method has precomputed for the scene's own view, or for all views.
async function drawBytes() {
  const { scene, method } = state;
  status.bytes(0);
  if (canvas.dataset.method !== method || (state.cameraMoved && !state.takes("camera"))) return;
  const { methods } = await call(`api/scenes/${encodeURIComponent(scene.name)}`);
  if (scene === state.scene && method === state.method) {
    status.bytes(methods.find(({ name }) => name === method)?.bytes ?? 0);
  }
}

function showFrame(bitmap, header, roundTrip, cause) {
  const { width, height } = state.camera;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  // The quick filter: the best one takes longer than the service needs for the frame.
  context.imageSmoothingQuality = "low";
  // A smaller frame holds every second pixel, the first one of each pair.
  const shift = (1 - header.scale) / 2;
  context.drawImage(bitmap, shift, shift, header.width * header.scale, header.height * header.scale);
  const other = ["method", "preview"].some((key) => canvas.dataset[key] !== String(header[key]));
  for (const key of ["seq", "scale", "format", "method", "preview"]) canvas.dataset[key] = header[key];
  // What the method makes of the materials is known once its product is there.
  if (other) {
    materials.refresh();
    editor.refit();
    drawBytes();
  }
  const final = requests.isFinal(header);
  canvas.dataset.state = final ? "final" : "changing";
  if (final) compare.keep();
  find("waiting").hidden = true;
  requests.took(header);
  front.took(header);
  status.frame(header, roundTrip);
  if (cause === null) return;
  // From the event that caused the frame to the moment the browser presents it.
  requestAnimationFrame(() => {
    if (performance.getEntriesByName("pointer-to-pixels").length > 2000) {
      performance.clearMeasures("pointer-to-pixels");
    }
    performance.measure("pointer-to-pixels", {
      start: cause, end: performance.now(), detail: { seq: header.seq, scale: header.scale },
    });
  });
}

function drawFacts(scene) {
  const facts = {
    Triangles: scene.triangles.toLocaleString("en"),
    Objects: scene.objects.length,
    Materials: scene.materials.length,
    Picture: `${scene.camera.width} × ${scene.camera.height}`,
  };
  find("facts").replaceChildren(
    ...Object.entries(facts).flatMap(([name, value]) => [node("dt", name), node("dd", value)]),
  );
  find("scene-warnings").replaceChildren(...scene.warnings.map((w) => node("li", w.message)));
}

function node(tag, text) {
  return Object.assign(document.createElement(tag), { textContent: text });
}

async function open(known) {
  const { name } = known;
  live?.close();
  live = null;
  scenes.draw(name);
  const waiting = find("waiting");
  waiting.textContent = `Opening ${called(known)} …`;
  waiting.hidden = false;
  find("problem").hidden = true;
  status.job(null);
  let scene = null;
  try {
    scene = await call(`api/scenes/${encodeURIComponent(name)}`);
  } catch (error) {
    waiting.textContent = `${called(known)} cannot be opened.`;
    throw error;
  }
  document.title = `${called(known)} · Relight`;
  const { width, height } = scene.camera;
  find("stage").style.setProperty("--ratio", width / height);
  delete canvas.dataset.method;
  drawFacts(scene);
  live = new Live(name, {
    frame: showFrame,
    job: (job) => status.job(job),
    problem: (problem) => {
      if (problem.field === "materials" && "materials" in state.edits()) materials.again();
      else status.problem(problem);
    },
    connected: (way) => status.connected(way),
  });
  state.open(scene);
}

find("exposure").addEventListener("input", () => {
  state.setExposure(find("exposure").valueAsNumber, true);
});
find("exposure").addEventListener("change", () => {
  state.setExposure(find("exposure").valueAsNumber, false);
});
find("camera-reset").addEventListener("click", () => state.resetCamera());

await scenes.load();
const whole = Keep.asked();
await open(scenes.named(whole?.scene ?? new URLSearchParams(location.search).get("scene")));
if (whole !== null) keep.restore(whole);
