// Tabs, and the views in them; the page's state is in `towline`.

const towline = { player, charts: [], scene: null, map: null };

data.charts.forEach((spec, i) => towline.charts.push(new Chart(document.getElementById("chart-" + i), spec)));
if (data.scene) {
  towline.scene = new Scene(document.getElementById("scene"));
  towline.map = new Footprint(document.getElementById("map"));
}
player.views = [...(towline.scene ? [towline.scene, towline.map] : []), ...towline.charts];

function open(name) {
  for (const tab of document.querySelectorAll('[role="tab"]')) {
    const chosen = tab.id === "tab-" + name;
    tab.setAttribute("aria-selected", chosen);
    document.getElementById(tab.getAttribute("aria-controls")).hidden = !chosen;
    if (chosen) tab.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
  player.refresh();
}
towline.open = open;

for (const tab of document.querySelectorAll('[role="tab"]')) {
  tab.addEventListener("click", () => {
    const name = tab.id.slice("tab-".length);
    history.replaceState(null, "", "#" + name);
    open(name);
    window.scrollTo(0, 0);
  });
}

{
  const names = [...document.querySelectorAll('[role="tab"]')].map((tab) => tab.id.slice("tab-".length));
  const asked = () => (names.includes(location.hash.slice(1)) ? location.hash.slice(1) : names[0]);
  window.addEventListener("hashchange", () => open(asked()));
  player.setWindow(...player.window);
  open(asked());
  player.setTime(data.t[0]);
  new ResizeObserver(() => player.refresh()).observe(document.querySelector("main"));
}
