// The time that all views show: the slider, the play button, the window of the charts.

const data = JSON.parse(document.getElementById("data").textContent);

const player = {
  time: data.t[0],
  window: data.window || data.t.slice(),
  playing: false,
  speed: 1,
  views: [], // each: {visible(), setTime(), setWindow()}
  slider: document.getElementById("time"),

  setTime(t) {
    this.time = Math.min(Math.max(t, data.t[0]), data.t[1]);
    this.slider.value = this.time;
    document.getElementById("now").textContent = this.time.toFixed(1) + " s";
    for (const view of this.views) if (view.visible()) view.setTime(this.time);
  },

  setWindow(from, to) {
    this.window = [Math.max(from, data.t[0]), Math.min(to, data.t[1])];
    document.getElementById("whole").hidden = this.window[0] === data.t[0] && this.window[1] === data.t[1];
    for (const view of this.views) if (view.visible()) view.setWindow();
  },

  refresh() {
    for (const view of this.views) {
      if (!view.visible()) continue;
      view.setWindow();
      view.setTime(this.time);
    }
  },

  play(on) {
    this.playing = on;
    const button = document.getElementById("play");
    button.textContent = on ? "❚❚" : "▶";
    button.setAttribute("aria-label", on ? "pause" : "play");
    if (!on) return;
    if (this.time >= data.t[1]) this.setTime(data.t[0]);
    let last = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      this.setTime(this.time + ((now - last) / 1000) * this.speed);
      last = now;
      if (this.time >= data.t[1]) this.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  },

  setSpeed(speed) {
    this.speed = speed;
    document.getElementById("faster").textContent = "× " + speed;
  },
};

{
  const SPEEDS = [1, 2, 5, 10, 20, 50];
  const range = data.t[1] - data.t[0];
  player.slider.min = data.t[0];
  player.slider.max = data.t[1];
  player.slider.step = range > 0 ? range / 4000 : 1;
  player.slider.addEventListener("input", () => player.setTime(Number(player.slider.value)));
  document.getElementById("play").addEventListener("click", () => player.play(!player.playing));
  document.getElementById("whole").addEventListener("click", () => player.setWindow(...data.t));
  document.getElementById("faster").addEventListener("click", () => {
    player.setSpeed(SPEEDS[(SPEEDS.indexOf(player.speed) + 1) % SPEEDS.length]);
  });
  player.setSpeed(SPEEDS.findLast((s) => s <= Math.max(1, range / 40)));
  document.addEventListener("keydown", (event) => {
    if (event.target.tagName === "INPUT" || event.target.tagName === "BUTTON") return;
    if (event.key === " ") player.play(!player.playing);
    else if (event.key === "ArrowRight") player.setTime(player.time + range / 200);
    else if (event.key === "ArrowLeft") player.setTime(player.time - range / 200);
    else return;
    event.preventDefault();
  });
}
