// Times of day and other surroundings, to choose as one chooses a map.

import { sunDirection } from "./sun.js";

// A sky whose brightness is for the exposure of a room: its own is that of a day.
const sky = (height, azimuth, turbidity, intensity) => ({ height, azimuth, turbidity, intensity });

export const SKIES = {
  dawn: { label: "Dawn", sky: sky(4, -70, 4, 0.5) },
  morning: { label: "Morning", sky: sky(25, -60, 3, 0.15) },
  noon: { label: "Noon", sky: sky(70, 20, 2.5, 0.14) },
  evening: { label: "Golden evening", sky: sky(8, 75, 6, 0.35) },
  overcast: { label: "Overcast", even: [0.78, 0.84, 0.9] },
  night: { label: "Moonlit", even: [0.012, 0.016, 0.03] },
};

// The environment of a preset; usual are the fields of a sky and those of an environment.
export function environmentOf(name, { sky: usual, environment }) {
  const { sky: wanted, even } = SKIES[name];
  if (even) return { ...environment, map: even, intensity: 1 };
  const { height, azimuth, turbidity, intensity } = wanted;
  const map = { ...usual, sun_direction: sunDirection({ height, azimuth }), turbidity };
  return { ...environment, map, intensity };
}
