// The lines and bodies in space, drawn with plain canvas: drag to turn, wheel or pinch to zoom.

const HULL = [[0.5, 0], [0.36, 0.36], [0.18, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.18, -0.5], [0.36, -0.36]];
const LINE_COLORS = ["#d9630c", "#8a3ffc", "#0a7d55", "#b0307f"];

class Scene {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.box = places.box();
    this.camera = new Camera(this.box);
    this.bounds = this.frame();
    this.fits = true; // until it is zoomed by hand
    this.points = []; // of the first line, in pixels, as drawn last
    this.listen();
  }

  visible() {
    return this.canvas.offsetParent !== null;
  }

  setWindow() {
    const ratio = window.devicePixelRatio || 1;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  }

  project(point) {
    return this.camera.project(point, this.width, this.height);
  }

  setTime(t) {
    const { pen } = this;
    pen.clearRect(0, 0, this.width, this.height);
    if (this.fits) this.camera.fit(this.bounds.corners, this.width, this.height);
    this.grid();
    for (const body of data.scene.bodies) this.trail(body);
    data.scene.lines.forEach((line, i) => this.line(line, t, i));
    for (const one of data.scene.markers) this.dots(one, t);
    const bodies = data.scene.bodies.map((body) => ({ body, at: places.at(body, t) }));
    bodies.sort((a, b) => this.project(b.at)[2] - this.project(a.at)[2]);
    for (const { body, at } of bodies) this.body(body, at, t);
    this.compass();
    this.names();
  }

  // Of the lines, in their colours, where there is more than one.
  names() {
    if (data.scene.lines.length < 2) return;
    this.pen.font = FONT;
    this.pen.textAlign = "left";
    this.pen.textBaseline = "middle";
    data.scene.lines.forEach((line, i) => {
      const y = 12 + 16 * i;
      this.path([[8, y], [24, y]], LINE_COLORS[i % LINE_COLORS.length], 2.5);
      this.pen.fillStyle = "#1c1c1c";
      this.pen.fillText(line.name, 30, y);
    });
  }

  path(points, color, width, dash = []) {
    const { pen } = this;
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.lineJoin = "round";
    pen.setLineDash(dash);
    pen.beginPath();
    points.forEach((p, i) => (i ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
    pen.stroke();
    pen.setLineDash([]);
  }

  // Edges of the grid on the water's surface, and the depth of the deepest point.
  frame() {
    const { low, high } = this.box;
    const size = Math.max(high[0] - low[0], high[1] - low[1], 0.3 * high[2], 1e-3);
    const step = ticks(0, size, 5)[1] || size;
    const edge = (i) => [Math.floor(low[i] / step) * step, Math.max(Math.ceil(high[i] / step), Math.floor(low[i] / step) + 1) * step];
    const [north, east] = [edge(0), edge(1)];
    const deepest = high[2] > 0.02 * size ? high[2] : 0;
    const corners = north.flatMap((n) => east.flatMap((e) => [[n, e, 0], [n, e, deepest]]));
    return { step, north, east, deepest, corners };
  }

  // That grid, labelled along the two edges that are nearest, and a scale of depth at its leftmost corner.
  grid() {
    const { pen } = this;
    const { step, north, east, deepest } = this.bounds;
    const rim = [[0, 0], [1, 0], [1, 1], [0, 1]].map(([i, j]) => this.project([north[i], east[j], 0]));
    pen.fillStyle = "rgba(63, 167, 214, 0.10)";
    pen.beginPath();
    rim.forEach((p, i) => (i ? pen.lineTo(p[0], p[1]) : pen.moveTo(p[0], p[1])));
    pen.fill();
    pen.font = FONT;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    const near = (a, b) => (this.project(a)[2] < this.project(b)[2] ? 0 : 1);
    const [n_mid, e_mid] = [(north[0] + north[1]) / 2, (east[0] + east[1]) / 2];
    const [e_side, n_side] = [near([n_mid, east[0], 0], [n_mid, east[1], 0]), near([north[0], e_mid, 0], [north[1], e_mid, 0])];
    const beside = (range, side) => range[side] + (side ? 0.3 : -0.3) * step;
    for (let n = north[0]; n <= north[1] + 1e-9 * step; n += step) {
      this.path([this.project([n, east[0], 0]), this.project([n, east[1], 0])], "rgba(18, 96, 138, 0.22)", 1);
      this.label("N " + shown(n), this.project([n, beside(east, e_side), 0]));
    }
    for (let e = east[0]; e <= east[1] + 1e-9 * step; e += step) {
      this.path([this.project([north[0], e, 0]), this.project([north[1], e, 0])], "rgba(18, 96, 138, 0.22)", 1);
      this.label("E " + shown(e), this.project([beside(north, n_side), e, 0]));
    }
    if (!deepest) return;
    const corners = north.flatMap((n) => east.map((e) => [n, e]));
    const [n, e] = corners.reduce((a, b) => (this.project([...b, 0])[0] < this.project([...a, 0])[0] ? b : a));
    this.path([this.project([n, e, 0]), this.project([n, e, deepest])], "#5b7686", 1);
    pen.textAlign = "right";
    for (const d of ticks(0, deepest, 4)) {
      const [x, y] = this.project([n, e, d]);
      this.path([[x - 4, y], [x, y]], "#5b7686", 1);
      if (d > 0) this.label(shown(d) + " m", [x - 6, y]);
    }
  }

  label(text, [x, y]) {
    this.pen.fillStyle = "#5b7686";
    this.pen.fillText(text, x, y);
  }

  trail(body) {
    const { frames, t } = data.scene;
    const every = Math.max(1, Math.floor(frames / 300));
    const points = [];
    for (let i = 0; i < frames; i += every) points.push(this.project(places.at(body, t[0] + ((t[1] - t[0]) * i) / Math.max(frames - 1, 1))));
    this.path(points, "rgba(90, 100, 110, 0.28)", 1);
  }

  line(line, t, index) {
    const at = places.at(line, t);
    const points = [];
    for (let i = 0; i < line.n; i++) points.push(this.project([at[3 * i], at[3 * i + 1], at[3 * i + 2]]));
    if (index === 0) this.points = points;
    this.path(points, "rgba(255, 255, 255, 0.9)", 4.5);
    this.path(points, LINE_COLORS[index % LINE_COLORS.length], 2.5);
  }

  dots(one, t) {
    const at = places.at(one, t);
    this.pen.fillStyle = "#1c1c1c";
    for (let i = 0; i < one.n; i++) {
      const [x, y] = this.project([at[3 * i], at[3 * i + 1], at[3 * i + 2]]);
      this.pen.beginPath();
      this.pen.arc(x, y, 2.5, 0, 7);
      this.pen.fill();
    }
  }

  body(body, at, t) {
    const { pen } = this;
    const here = this.project(at);
    if (Math.abs(at[2]) > 0.04 * this.camera.reach) this.path([here, this.project([at[0], at[1], 0])], "rgba(90, 100, 110, 0.5)", 1, [3, 3]);
    const turn = places.turned(body, t);
    if (turn) this.hull(body, at, turn);
    else {
      pen.fillStyle = "#2b4a5e";
      pen.beginPath();
      pen.arc(here[0], here[1], 4, 0, 7);
      pen.fill();
    }
    pen.font = "600 " + FONT;
    pen.textAlign = "left";
    pen.textBaseline = "bottom";
    pen.lineWidth = 3;
    pen.strokeStyle = "rgba(255, 255, 255, 0.85)";
    pen.strokeText(body.name, here[0] + 8, here[1] - 8);
    pen.fillStyle = "#1c2b36";
    pen.fillText(body.name, here[0] + 8, here[1] - 8);
  }

  // A ship's outline, or a small one for a body whose size is not told, large enough to be seen.
  hull(body, at, turn) {
    const least = (0.03 * this.camera.reach) / this.camera.zoom;
    const [length, beam, deep] = body.size || [least, 0.6 * least, 0.45 * least];
    const ring = (z) => placed(HULL.map(([x, y]) => [x * length, y * beam, z]), at, turn).map((p) => this.project(p));
    const [top, bottom] = body.size ? [ring(-0.55 * deep), ring(deep)] : [ring(-deep / 2), ring(deep / 2)];
    const faces = HULL.map((_, i) => {
      const j = (i + 1) % HULL.length;
      return { corners: [top[i], top[j], bottom[j], bottom[i]], color: "#4b7189" };
    });
    faces.push({ corners: top, color: "#8fb3c7" }, { corners: bottom, color: "#3a596c" });
    const depth = (face) => face.corners.reduce((sum, p) => sum + p[2], 0) / face.corners.length;
    faces.sort((a, b) => depth(b) - depth(a));
    for (const { corners, color } of faces) {
      this.pen.fillStyle = color;
      this.pen.beginPath();
      corners.forEach((p, i) => (i ? this.pen.lineTo(p[0], p[1]) : this.pen.moveTo(p[0], p[1])));
      this.pen.closePath();
      this.pen.fill();
      this.pen.strokeStyle = "rgba(255, 255, 255, 0.55)";
      this.pen.lineWidth = 0.7;
      this.pen.stroke();
    }
  }

  compass() {
    const { pen } = this;
    const [x, y] = [34, this.height - 34];
    const [c, s] = [Math.cos(this.camera.yaw), Math.sin(this.camera.yaw)];
    const tip = (n, e, size) => [x + size * (c * e + s * n), y - size * Math.sin(this.camera.pitch) * (c * n - s * e)];
    this.path([tip(-1, 0, 16), tip(1, 0, 20)], "#1c2b36", 1.5);
    pen.fillStyle = "#1c2b36";
    pen.font = "600 " + FONT;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText("N", ...tip(1, 0, 28));
  }

  zoom(factor) {
    this.fits = false;
    this.camera.zoom = Math.min(Math.max(this.camera.zoom * factor, 0.1), 100);
    this.camera.shift = this.camera.shift.map((s) => s * factor);
  }

  listen() {
    const pointers = new Map();
    const apart = () => {
      const [a, b] = [...pointers.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const gap = pointers.size === 2 ? apart() : 0;
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      if (pointers.size === 2) this.zoom(apart() / gap);
      else {
        this.camera.yaw -= (event.clientX - last[0]) * 0.008;
        this.camera.pitch = Math.min(Math.max(this.camera.pitch + (event.clientY - last[1]) * 0.008, -1.5), 1.5);
      }
      this.setTime(player.time);
    });
    for (const kind of ["pointerup", "pointercancel"]) this.canvas.addEventListener(kind, (event) => pointers.delete(event.pointerId));
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * 0.001));
      this.setTime(player.time);
    }, { passive: false });
    this.canvas.addEventListener("dblclick", () => {
      this.fits = true;
      this.setTime(player.time);
    });
  }
}
