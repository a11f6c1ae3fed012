// A figure over time: curves or bars, the cursor of the player's time, values under the pointer.

const MARGIN = { left: 70, right: 12, top: 8, bottom: 38 };
const FONT = "12px system-ui, sans-serif";

class Chart {
  constructor(figure, spec) {
    this.figure = figure;
    this.spec = spec;
    this.plot = figure.querySelector(".plot");
    this.base = this.plot.appendChild(document.createElement("canvas"));
    this.over = this.plot.appendChild(document.createElement("canvas"));
    this.series = null; // decoded when first shown
    this.hover = null;
    this.listen();
  }

  visible() {
    return this.figure.offsetParent !== null;
  }

  decode() {
    let color = 0;
    this.series = this.spec.series.map((one) => ({
      name: one.name,
      kind: one.kind,
      color: one.faint ? FAINT : COLORS[color++ % COLORS.length],
      faint: one.faint,
      t: floats(one.t),
      v: floats(one.v),
      shown: true,
    }));
    const legend = this.figure.querySelector(".legend");
    for (const one of this.series) {
      const key = legend.appendChild(document.createElement("button"));
      key.innerHTML = '<i></i><span></span> <b></b>';
      key.querySelector("i").style.background = one.color;
      key.querySelector("span").textContent = one.name;
      key.title = "show or hide";
      key.addEventListener("click", () => {
        one.shown = !one.shown;
        key.classList.toggle("off", !one.shown);
        this.setWindow();
      });
      one.label = key.querySelector("b");
    }
    if (this.spec.lanes.length) this.plot.style.height = MARGIN.top + MARGIN.bottom + 22 * this.spec.lanes.length + "px";
  }

  size() {
    const ratio = window.devicePixelRatio || 1;
    this.width = this.plot.clientWidth;
    this.height = this.plot.clientHeight;
    for (const canvas of [this.base, this.over]) {
      canvas.width = Math.round(this.width * ratio);
      canvas.height = Math.round(this.height * ratio);
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.left = this.spec.lanes.length ? Math.min(130, this.width * 0.34) : MARGIN.left;
  }

  // Pixels of a time and of a value.
  x(t) {
    const [from, to] = player.window;
    return this.left + ((t - from) / (to - from || 1)) * (this.width - this.left - MARGIN.right);
  }

  time(x) {
    const [from, to] = player.window;
    return from + ((x - this.left) / (this.width - this.left - MARGIN.right)) * (to - from);
  }

  y(value) {
    const v = this.spec.log ? Math.log10(value) : value;
    return MARGIN.top + ((this.high - v) / (this.high - this.low || 1)) * (this.height - MARGIN.top - MARGIN.bottom);
  }

  scale() {
    let low = Infinity;
    let high = -Infinity;
    const [from, to] = player.window;
    for (const one of this.series) {
      if (!one.shown) continue;
      for (let i = 0; i < one.t.length; i++) {
        const v = one.v[i];
        if (one.t[i] < from || one.t[i] > to || !Number.isFinite(v) || (this.spec.log && v <= 0)) continue;
        if (v < low) low = v;
        if (v > high) high = v;
      }
    }
    const data = high - low;
    for (const limit of this.spec.limits) {
      const far = this.spec.log ? limit.value > 30 * high || limit.value < low / 30 : Math.abs(limit.value) > 4 * Math.max(Math.abs(low), Math.abs(high));
      if (far && data > 0) continue;
      low = Math.min(low, limit.value);
      high = Math.max(high, limit.value);
    }
    if (!(low <= high)) [low, high] = [this.spec.log ? 0.1 : 0, 1];
    if (this.spec.log) {
      [low, high] = [Math.max(Math.log10(low), Math.log10(high) - 4), Math.log10(high)];
      if (high - low < 0.2) [low, high] = [low - 0.1, high + 0.1];
    } else if (high - low < 1e-6 * Math.max(Math.abs(high), 1e-9)) {
      const about = Math.abs(high) * 0.05 || 1;
      [low, high] = [low - about, high + about];
    }
    const room = 0.04 * (high - low);
    [this.low, this.high] = [low - room, high + room];
  }

  setWindow() {
    if (!this.series) this.decode();
    this.size();
    const pen = this.base.getContext("2d");
    pen.clearRect(0, 0, this.width, this.height);
    pen.font = FONT;
    this.scale();
    this.axes(pen);
    pen.save();
    pen.beginPath();
    pen.rect(this.left, MARGIN.top - 1, this.width - this.left - MARGIN.right, this.height - MARGIN.top - MARGIN.bottom + 2);
    pen.clip();
    this.marks(pen);
    for (const one of this.series) if (one.shown && one.faint) this.curve(pen, one);
    for (const one of this.series) if (one.shown && !one.faint) this.curve(pen, one);
    pen.restore();
    this.setTime(player.time);
  }

  axes(pen) {
    const bottom = this.height - MARGIN.bottom;
    pen.lineWidth = 1;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const t of ticks(...player.window, Math.max(2, (this.width - this.left) / 90))) {
      const x = Math.round(this.x(t)) + 0.5;
      this.rule(pen, x, MARGIN.top, x, bottom, "#edf0f2");
      pen.fillStyle = "#555";
      pen.fillText(shown(t), x, bottom + 5);
    }
    pen.fillStyle = "#333";
    pen.fillText(this.spec.x, (this.left + this.width - MARGIN.right) / 2, bottom + 20);
    if (this.spec.lanes.length) return this.lanes(pen);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const v of this.levels()) {
      const y = Math.round(this.y(v)) + 0.5;
      this.rule(pen, this.left, y, this.width - MARGIN.right, y, v === 0 ? "#c3cad0" : "#edf0f2");
      pen.fillStyle = "#555";
      pen.fillText(shown(v), this.left - 5, y);
    }
    this.rule(pen, this.left + 0.5, MARGIN.top, this.left + 0.5, bottom, "#9aa5ae");
    this.rule(pen, this.left, bottom + 0.5, this.width - MARGIN.right, bottom + 0.5, "#9aa5ae");
    pen.save();
    pen.translate(12, (MARGIN.top + bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillStyle = "#333";
    pen.fillText(this.spec.y, 0, 0);
    pen.restore();
  }

  levels() {
    const count = Math.max(2, (this.height - MARGIN.top - MARGIN.bottom) / 34);
    if (!this.spec.log) return ticks(this.low, this.high, count);
    const found = [];
    for (let p = Math.floor(this.low); p <= this.high; p++) {
      for (const m of this.high - this.low > 2.5 ? [1] : [1, 2, 5]) {
        if (Math.log10(m) + p >= this.low && Math.log10(m) + p <= this.high) found.push(m * 10 ** p);
      }
    }
    return found;
  }

  lanes(pen) {
    this.spec.lanes.forEach((lane, i) => {
      const y = MARGIN.top + 22 * i;
      pen.fillStyle = "#333";
      pen.textAlign = "right";
      pen.textBaseline = "middle";
      pen.fillText(lane.name, this.left - 6, y + 11, this.left - 8);
      pen.fillStyle = "#f3f5f7";
      pen.fillRect(this.left, y + 3, this.width - this.left - MARGIN.right, 16);
      pen.fillStyle = COLORS[0];
      for (const [from, to] of lane.spans) {
        const a = Math.max(this.x(from), this.left);
        const b = Math.min(this.x(to), this.width - MARGIN.right);
        if (b >= this.left && a <= this.width - MARGIN.right) pen.fillRect(a, y + 3, Math.max(b - a, 1), 16);
      }
    });
  }

  marks(pen) {
    const bottom = this.height - MARGIN.bottom;
    pen.fillStyle = "rgba(209, 73, 91, 0.13)";
    for (const [from, to] of this.spec.bands) {
      pen.fillRect(this.x(from), MARGIN.top, Math.max(this.x(to) - this.x(from), 1), bottom - MARGIN.top);
    }
    pen.setLineDash([2, 4]);
    for (const [t] of data.events) this.rule(pen, this.x(t), MARGIN.top, this.x(t), bottom, "#a58a4d");
    pen.setLineDash([6, 4]);
    pen.textAlign = "right";
    pen.textBaseline = "bottom";
    for (const limit of this.spec.limits) {
      const y = this.y(limit.value);
      this.rule(pen, this.left, y, this.width - MARGIN.right, y, COLORS[1]);
      pen.fillStyle = COLORS[1];
      pen.fillText(limit.name, this.width - MARGIN.right - 3, y > MARGIN.top + 16 ? y - 2 : y + 15);
    }
    pen.setLineDash([]);
  }

  curve(pen, one) {
    const [from, to] = player.window;
    const first = Math.max(0, before(one.t, from) - 1);
    const last = Math.min(one.t.length - 1, before(one.t, to) + 2);
    pen.strokeStyle = pen.fillStyle = one.color;
    pen.lineWidth = 1.3;
    if (one.kind === "dots") {
      for (let i = first; i <= last; i++) if (one.v[i] > 0 || !this.spec.log) pen.fillRect(this.x(one.t[i]) - 1, this.y(one.v[i]) - 1, 2, 2);
      return;
    }
    pen.beginPath();
    let down = false;
    for (let i = first; i <= last; i++) {
      const v = one.v[i];
      if (!Number.isFinite(v) || (this.spec.log && v <= 0)) {
        down = false;
        continue;
      }
      const x = this.x(one.t[i]);
      const y = this.y(v);
      if (!down) pen.moveTo(x, y);
      else {
        if (one.kind === "step") pen.lineTo(x, this.y(one.v[i - 1]));
        pen.lineTo(x, y);
      }
      down = true;
    }
    pen.stroke();
  }

  rule(pen, x0, y0, x1, y1, color) {
    pen.strokeStyle = color;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(x0, y0);
    pen.lineTo(x1, y1);
    pen.stroke();
  }

  setTime(time) {
    const pen = this.over.getContext("2d");
    pen.clearRect(0, 0, this.width, this.height);
    const t = this.hover === null ? time : this.hover;
    const bottom = this.height - MARGIN.bottom;
    if (this.drag) {
      pen.fillStyle = "rgba(18, 96, 138, 0.15)";
      pen.fillRect(Math.min(...this.drag), MARGIN.top, Math.abs(this.drag[1] - this.drag[0]), bottom - MARGIN.top);
    }
    for (const [at, color] of [[time, "#12608a"], [this.hover, "#777"]]) {
      if (at !== null && at >= player.window[0] && at <= player.window[1]) this.rule(pen, this.x(at), MARGIN.top, this.x(at), bottom, color);
    }
    for (const one of this.series) {
      const v = one.t.length ? one.v[before(one.t, t)] : NaN;
      one.label.textContent = shown(v);
      if (!one.shown || !Number.isFinite(v) || (this.spec.log && v <= 0) || one.kind === "dots") continue;
      pen.fillStyle = one.color;
      pen.beginPath();
      pen.arc(this.x(t), this.y(v), 3, 0, 7);
      if (t >= player.window[0] && t <= player.window[1]) pen.fill();
    }
    if (this.hover !== null) {
      pen.font = FONT;
      pen.fillStyle = "#333";
      pen.textBaseline = "top";
      pen.textAlign = this.x(t) > this.width / 2 ? "right" : "left";
      pen.fillText(t.toFixed(2) + " s", this.x(t) + (this.x(t) > this.width / 2 ? -5 : 5), MARGIN.top);
    }
  }

  listen() {
    const at = (event) => event.clientX - this.over.getBoundingClientRect().left;
    const clamp = (x) => Math.min(Math.max(x, this.left), this.width - MARGIN.right);
    let start = null;
    this.over.addEventListener("pointerdown", (event) => {
      start = clamp(at(event));
      this.over.setPointerCapture(event.pointerId);
      if (event.pointerType !== "mouse") player.setTime(this.time(start));
    });
    this.over.addEventListener("pointermove", (event) => {
      const x = clamp(at(event));
      if (event.pointerType !== "mouse") {
        if (start !== null) player.setTime(this.time(x));
        return;
      }
      this.drag = start !== null && Math.abs(x - start) > 6 ? [start, x] : null;
      this.hover = this.time(x);
      this.setTime(player.time);
    });
    this.over.addEventListener("pointerup", () => {
      if (this.drag) player.setWindow(this.time(Math.min(...this.drag)), this.time(Math.max(...this.drag)));
      else if (start !== null) player.setTime(this.time(start));
      start = this.drag = null;
    });
    this.over.addEventListener("pointercancel", () => (start = this.drag = null));
    this.over.addEventListener("pointerleave", () => {
      this.hover = null;
      if (this.series) this.setTime(player.time);
    });
    this.over.addEventListener("dblclick", () => player.setWindow(...data.t));
  }
}
