// Places of lines and bodies at the player's time, and a camera that turns about the middle of the scene.

const places = {
  // Coordinates [north, east, down, ...] of something drawn, between the two frames beside t.
  at(one, t) {
    if (!one.q) one.q = whole(one.data);
    const { t: range, frames } = data.scene;
    const f = range[1] > range[0] ? ((t - range[0]) / (range[1] - range[0])) * (frames - 1) : 0;
    const i = Math.min(Math.max(Math.floor(f), 0), Math.max(frames - 2, 0));
    const share = frames > 1 ? Math.min(Math.max(f - i, 0), 1) : 0;
    const width = 3 * one.n;
    const found = new Float64Array(width);
    const next = frames > 1 ? width : 0;
    for (let j = 0; j < width; j++) {
      const raw = one.q[i * width + j] * (1 - share) + one.q[i * width + next + j] * share;
      found[j] = one.min[j % 3] + (raw / 65535) * one.span[j % 3];
    }
    return found;
  },

  turned(body, t) {
    if (!body.attitude) return null;
    if (!body.a) body.a = floats(body.attitude);
    const { t: range, frames } = data.scene;
    const f = range[1] > range[0] ? ((t - range[0]) / (range[1] - range[0])) * (frames - 1) : 0;
    const i = Math.min(Math.max(Math.round(f), 0), frames - 1);
    return body.a.subarray(3 * i, 3 * i + 3);
  },

  // Least and greatest corner of all that is drawn over the whole record.
  box() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (const one of [...data.scene.lines, ...data.scene.bodies, ...data.scene.markers]) {
      const room = one.size ? one.size[0] / 2 : 0;
      for (let i = 0; i < 3; i++) {
        low[i] = Math.min(low[i], one.min[i] - (i < 2 ? room : 0));
        high[i] = Math.max(high[i], one.min[i] + one.span[i] + (i < 2 ? room : 0));
      }
    }
    return { low, high };
  },
};

// Corners of a body in the world: points forward, starboard, down, turned by roll, pitch and yaw.
function placed(points, at, turn) {
  const [cr, sr, cp, sp, cy, sy] = [Math.cos(turn[0]), Math.sin(turn[0]), Math.cos(turn[1]), Math.sin(turn[1]), Math.cos(turn[2]), Math.sin(turn[2])];
  return points.map(([x, y, z]) => [
    at[0] + cy * cp * x + (cy * sp * sr - sy * cr) * y + (cy * sp * cr + sy * sr) * z,
    at[1] + sy * cp * x + (sy * sp * sr + cy * cr) * y + (sy * sp * cr - cy * sr) * z,
    at[2] - sp * x + cp * sr * y + cp * cr * z,
  ]);
}

class Camera {
  constructor(box) {
    this.middle = [0, 1, 2].map((i) => (box.low[i] + box.high[i]) / 2);
    this.reach = Math.max(0.5 * Math.hypot(...[0, 1, 2].map((i) => box.high[i] - box.low[i])), 0.1);
    this.yaw = 0.65;
    this.pitch = 0.35;
    this.zoom = 1;
    this.shift = [0, 0]; // of the middle, in pixels
  }

  // So near that these points fill the picture.
  fit(points, width, height) {
    this.zoom = 1;
    this.shift = [0, 0];
    const seen = points.map((point) => this.project(point, width, height));
    const [xs, ys] = [seen.map((p) => p[0]), seen.map((p) => p[1])];
    const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    this.zoom = Math.min((width - 100) / Math.max(x1 - x0, 1), (height - 64) / Math.max(y1 - y0, 1));
    this.shift = [-this.zoom * ((x0 + x1 - width) / 2), -this.zoom * ((y0 + y1 - height) / 2)];
  }

  // Pixels and depth of a point [north, east, down].
  project([n, e, d], width, height) {
    const [x, y, z] = [e - this.middle[1], n - this.middle[0], this.middle[2] - d];
    const [c, s] = [Math.cos(this.yaw), Math.sin(this.yaw)];
    const right = c * x + s * y;
    const away = -s * x + c * y;
    const [cp, sp] = [Math.cos(this.pitch), Math.sin(this.pitch)];
    const up = cp * z + sp * away;
    const far = cp * away - sp * z;
    const distance = 3.2 * this.reach;
    const f = (this.zoom * Math.min(width, height * 1.25) * 0.6 * distance) / (this.reach * Math.max(distance + far, 0.1 * distance));
    return [width / 2 + this.shift[0] + f * right, height / 2 + this.shift[1] - f * up, far];
  }
}
