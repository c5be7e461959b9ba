// Where the sun of a clear sky stands, as angles and as the direction that its light travels in.

const RADIANS = Math.PI / 180;

// Height above the horizon; azimuth from -z towards +x, where the middle of a map is.
export function sunAngles([x, y, z]) {
  const length = Math.hypot(x, y, z);
  return {
    height: Math.asin(-y / length) / RADIANS,
    azimuth: Math.atan2(-x, z) / RADIANS,
  };
}

export function sunDirection({ height, azimuth }) {
  const flat = Math.cos(height * RADIANS);
  return [
    -flat * Math.sin(azimuth * RADIANS),
    -Math.sin(height * RADIANS),
    flat * Math.cos(azimuth * RADIANS),
  ];
}

// A turn of the map takes its sun along, counter-clockwise as seen from above.
export function turned(direction, degrees) {
  const { height, azimuth } = sunAngles(direction);
  return sunDirection({ height, azimuth: azimuth - degrees });
}

// Where the sun of an environment stands in the world; null where its map is no clear sky.
export function skySun(environment) {
  const direction = environment?.map?.sun_direction;
  return direction ? turned(direction, environment.rotation_degrees) : null;
}

export function isAlong(a, b) {
  const product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  return product > Math.cos(0.5 * RADIANS) * Math.hypot(...a) * Math.hypot(...b);
}
