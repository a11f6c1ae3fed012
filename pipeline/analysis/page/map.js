// The footprint: tracks of bodies and what they were told, and the lines from above, at one scale north and east.

class Footprint {
  constructor(canvas) {
    this.canvas = canvas;
    this.pen = canvas.getContext("2d");
    this.paths = data.scene.paths.map((path) => ({ name: path.name, at: floats(path.data) }));
    this.box = places.box();
    for (const path of this.paths) {
      for (let i = 0; i < path.at.length; i++) {
        this.box.low[i % 2] = Math.min(this.box.low[i % 2], path.at[i]);
        this.box.high[i % 2] = Math.max(this.box.high[i % 2], path.at[i]);
      }
    }
  }

  visible() {
    return this.canvas.offsetParent !== null;
  }

  setWindow() {
    Scene.prototype.setWindow.call(this);
    const { low, high } = this.box;
    const [inside, tall] = [this.width - 70, this.height - 58];
    this.scale = Math.min(inside / Math.max(high[1] - low[1], 1e-3), tall / Math.max(high[0] - low[0], 1e-3)) * 0.92;
    this.middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  }

  project([n, e]) {
    return [60 + (this.width - 70) / 2 + this.scale * (e - this.middle[1]), 8 + (this.height - 58) / 2 - this.scale * (n - this.middle[0])];
  }

  setTime(t) {
    const { pen } = this;
    pen.clearRect(0, 0, this.width, this.height);
    this.axes();
    for (const { at } of this.paths) {
      const points = [];
      for (let i = 0; i < at.length; i += 2) points.push(this.project([at[i], at[i + 1]]));
      this.path(points, "#d98218", 1.2, [5, 4]);
    }
    data.scene.bodies.forEach((body, i) => this.track(body, t, COLORS[i % COLORS.length]));
    data.scene.lines.forEach((line, i) => {
      const at = places.at(line, t);
      const points = [];
      for (let j = 0; j < line.n; j++) points.push(this.project([at[3 * j], at[3 * j + 1]]));
      this.path(points, LINE_COLORS[i % LINE_COLORS.length], 2);
    });
    data.scene.bodies.forEach((body, i) => this.body(body, t, COLORS[i % COLORS.length]));
  }

  axes() {
    const { pen } = this;
    const bottom = this.height - 50;
    pen.font = FONT;
    const east = [this.middle[1] - (this.width - 70) / 2 / this.scale, this.middle[1] + (this.width - 70) / 2 / this.scale];
    const north = [this.middle[0] - (this.height - 58) / 2 / this.scale, this.middle[0] + (this.height - 58) / 2 / this.scale];
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const e of ticks(...east, this.width / 80)) {
      const [x] = this.project([0, e]);
      this.path([[x, 8], [x, bottom]], "#edf0f2", 1);
      pen.fillStyle = "#555";
      pen.fillText(shown(e), x, bottom + 5);
    }
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const n of ticks(...north, this.height / 60)) {
      const [, y] = this.project([n, 0]);
      this.path([[60, y], [this.width - 10, y]], "#edf0f2", 1);
      pen.fillStyle = "#555";
      pen.fillText(shown(n), 55, y);
    }
    pen.fillStyle = "#333";
    pen.textAlign = "center";
    pen.fillText("east [m]", 60 + (this.width - 70) / 2, bottom + 30);
    pen.save();
    pen.translate(12, 8 + (this.height - 58) / 2);
    pen.rotate(-Math.PI / 2);
    pen.fillText("north [m]", 0, 0);
    pen.restore();
  }

  track(body, t, color) {
    const { frames, t: range } = data.scene;
    const every = Math.max(1, Math.floor(frames / 600));
    const points = [];
    const past = [];
    for (let i = 0; i < frames; i += every) {
      const time = range[0] + ((range[1] - range[0]) * i) / Math.max(frames - 1, 1);
      const p = this.project(places.at(body, time));
      points.push(p);
      if (time <= t) past.push(p);
    }
    this.path(points, "#cdd4da", 1.2);
    this.path(past, color, 1.6);
  }

  body(body, t, color) {
    const { pen } = this;
    const at = places.at(body, t);
    const [x, y] = this.project(at);
    const turn = places.turned(body, t);
    pen.fillStyle = color;
    if (turn) {
      const least = 12 / this.scale;
      const [length, beam] = body.size && body.size[0] > least ? body.size : [least, 0.55 * least];
      const outline = placed(HULL.map(([u, v]) => [u * length, v * beam, 0]), at, [0, 0, turn[2]]).map((p) => this.project(p));
      pen.globalAlpha = 0.75;
      pen.beginPath();
      outline.forEach((p, i) => (i ? pen.lineTo(...p) : pen.moveTo(...p)));
      pen.fill();
      pen.globalAlpha = 1;
    } else {
      pen.beginPath();
      pen.arc(x, y, 4, 0, 7);
      pen.fill();
    }
    pen.font = "600 " + FONT;
    pen.textAlign = x > this.width * 0.7 ? "right" : "left";
    pen.textBaseline = "bottom";
    pen.lineWidth = 3;
    pen.strokeStyle = "rgba(255, 255, 255, 0.9)";
    const beside = x + (x > this.width * 0.7 ? -8 : 8);
    pen.strokeText(body.name, beside, y - 8);
    pen.fillText(body.name, beside, y - 8);
  }

  path(points, color, width, dash) {
    Scene.prototype.path.call(this, points, color, width, dash);
  }
}
