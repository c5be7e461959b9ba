// Lights as the page has them: as the service describes them, and two things that it knows nothing of.
//   locked      the light stays as it is but for its switches
//   multiplier  of its intensity, 1 where there is none

// Without what says nothing, so that a light that is as it was is equal to what it was.
export function tidy({ locked, multiplier = 1, ...light }) {
  if (locked) light.locked = true;
  if (multiplier !== 1) light.multiplier = multiplier;
  return light;
}

// As edits take it.
export function asWire({ locked: _, multiplier = 1, ...light }) {
  if (multiplier === 1) return light;
  return { ...light, intensity: light.intensity.map((c) => c * multiplier) };
}

// What edits do not say, by id.
export function marksOf(lights) {
  const marked = lights.filter(({ locked, multiplier }) => locked || multiplier !== undefined);
  return Object.fromEntries(marked.map(({ id, locked, multiplier }) => [id, { locked, multiplier }]));
}

// A light of edits with its marks again: its intensity is that before the multiplier.
export function marked(light, { locked = false, multiplier = 1 } = {}) {
  const intensity = multiplier > 0 ? light.intensity.map((c) => c / multiplier) : light.intensity;
  return tidy({ ...light, intensity, locked, multiplier });
}
