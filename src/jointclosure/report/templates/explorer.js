"use strict";
// The figure of closure curves: menus choose, Plotly draws. Data: jointclosure.report.curves.

const data = JSON.parse(document.getElementById("explorer-data").textContent);
const menus = Object.fromEntries(
  ["rock", "parameter", "level", "cycle", "origin"].map((name) => [name, document.getElementById(`choose-${name}`)])
);
const COLOURS = ["#0173b2", "#de8f05", "#029e73", "#cc78bc", "#ca9161", "#949494", "#d55e00", "#56b4e9"];
const BRANCHES = ["loading", "unloading"];
const ALL = "all";
const OPTIONS = {
  responsive: true,
  displaylogo: false,
  modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
  toImageButtonOptions: { filename: "closure", scale: 2 },
};

function fill(menu, choices) {
  const before = menu.value;
  menu.replaceChildren(...choices.map(([value, text]) => new Option(text, value)));
  if (choices.some(([value]) => String(value) === before)) menu.value = before;
}

const rock = () => data.rocks[Number(menus.rock.value)];
const levelName = (one) =>
  menus.parameter.value === "base" ? "as it is" : `${one.values[menus.parameter.value]}${one.parameter === "base" ? " (its own)" : ""}`;

// the cases of what is changed: the rock as it is among its levels, in order of value
function cases() {
  const parameter = menus.parameter.value;
  const base = rock().cases.filter((one) => one.parameter === "base");
  if (parameter === "base") return base;
  const all = [...base, ...rock().cases.filter((one) => one.parameter === parameter)];
  return all.sort((one, other) => parseFloat(one.values[parameter]) - parseFloat(other.values[parameter]));
}

function fillParameters() {
  const varied = rock().parameters.map((one) => [one.name, one.title]);
  fill(menus.parameter, [["base", "nothing: the rock as it is"], ...varied]);
}

function fillLevels() {
  const levels = cases().map((one) => [one.level, levelName(one)]);
  fill(menus.level, levels.length > 1 ? [[ALL, "all, means only"], ...levels] : levels);
}

const chosenCases = () => cases().filter((one) => [ALL, one.level].includes(menus.level.value));
const chosenCycles = () => data.cycles.filter((cycle) => [ALL, String(cycle)].includes(menus.cycle.value));

// points of a curve: since seating from there on, where loading is at zero by definition
function points(closures, branch) {
  const stress = rock().stress;
  if (menus.origin.value !== "1") return { x: closures, y: stress };
  const kept = stress.map((_, i) => i).filter((i) => stress[i] > data.seating);
  const first = branch ? [] : [[0, data.seating]];
  return {
    x: [...first.map((one) => one[0]), ...kept.map((i) => closures[i])],
    y: [...first.map((one) => one[1]), ...kept.map((i) => stress[i])],
  };
}

function jointTrace(joint, cycle, branch, colour) {
  const c = data.cycles.indexOf(cycle);
  const shift = [0, joint.seats[c], joint.starts[c]][Number(menus.origin.value)];
  const closures = joint.curves[c][branch].map((one) => (one === null || shift === null ? null : one - shift));
  return {
    ...points(closures, branch),
    mode: "lines",
    line: { color: colour, width: 0.7, dash: branch ? "dash" : "solid" },
    opacity: 0.45,
    showlegend: false,
    name: `joint ${joint.number}, cycle ${cycle}, ${BRANCHES[branch]}`,
    hovertemplate: "%{x:.4g} mm at %{y:.3g} MPa",
  };
}

function bandTrace(mean, deviation, colour) {
  const known = rock().stress.map((_, i) => i).filter(
    (i) => mean[i] !== null && deviation[i] !== null && (menus.origin.value !== "1" || rock().stress[i] > data.seating)
  );
  const edge = (sign) => known.map((i) => mean[i] + sign * deviation[i]);
  const stress = known.map((i) => rock().stress[i]);
  return {
    x: [...edge(-1), ...edge(1).reverse()],
    y: [...stress, ...stress.slice().reverse()],
    mode: "none",
    fill: "toself",
    fillcolor: `${colour}22`,
    hoverinfo: "skip",
    showlegend: false,
  };
}

function meanTrace(one, cycle, branch, colour, name) {
  const c = data.cycles.indexOf(cycle);
  return {
    ...points(one.mean[Number(menus.origin.value)][c][branch], branch),
    mode: "lines",
    line: { color: colour, width: 2.5, dash: branch ? "dash" : "solid" },
    showlegend: branch === 0,
    name: branch === 0 ? name : `${name}, unloading`,
    hovertemplate: "%{x:.4g} mm at %{y:.3g} MPa",
  };
}

function traces() {
  const several = chosenCases().length > 1;
  const found = [];
  chosenCases().forEach((one, i) =>
    chosenCycles().forEach((cycle) => {
      const colour = COLOURS[(several ? i : data.cycles.indexOf(cycle)) % COLOURS.length];
      const name = several ? `${levelName(one)}, cycle ${cycle}` : `mean, cycle ${cycle}`;
      const c = data.cycles.indexOf(cycle);
      const origin = Number(menus.origin.value);
      for (const branch of [0, 1]) {
        if (!several) {
          found.push(...one.joints.map((joint) => jointTrace(joint, cycle, branch, colour)));
          if (branch === 0) found.push(bandTrace(one.mean[origin][c][0], one.deviation[origin][c][0], colour));
        }
        found.push(meanTrace(one, cycle, branch, colour, name));
      }
    })
  );
  return found;
}

function last(values) {
  for (let i = values.length - 1; i >= 0; i--) if (values[i] !== null) return i;
  return -1;
}

// what the figure shows, in numbers
function fillTable() {
  const origin = Number(menus.origin.value);
  const from = menus.origin.selectedOptions[0].text;
  const table = document.querySelector("#explored table");
  const line = (tag, texts) => {
    const row = document.createElement("tr");
    texts.forEach((text, i) => {
      const cell = document.createElement(tag === "th" || i === 0 ? "th" : "td");
      cell.scope = tag === "th" ? "col" : "row";
      cell.className = i === 0 ? "word" : "number";
      cell.textContent = text;
      row.append(cell);
    });
    return row;
  };
  const round = (value) => (value === null ? "–" : value.toPrecision(4));
  table.tHead.replaceChildren(line("th", ["Level", "Cycle", "Stress (MPa)", "Closure, mean (mm)", "Standard deviation (mm)", "Joints (n)"]));
  const rows = chosenCases().flatMap((one) =>
    chosenCycles().map((cycle) => {
      const c = data.cycles.indexOf(cycle);
      const at = last(one.mean[origin][c][0]);
      const used = one.used === one.of ? one.used : `${one.used} of ${one.of}`;
      if (at < 0) return line("td", [levelName(one), cycle, "–", "–", "–", used]);
      return line("td", [
        levelName(one), cycle, Number(rock().stress[at].toPrecision(4)), round(one.mean[origin][c][0][at]),
        round(one.deviation[origin][c][0][at]), used,
      ]);
    })
  );
  table.tBodies[0].replaceChildren(...rows);
  const changed = menus.parameter.value === "base" ? "as it is" : menus.parameter.selectedOptions[0].text;
  document.getElementById("explored-title").textContent =
    `${rock().title}, ${changed}: closure from ${from}, at the largest stress of loading that all joints have`;
}

function draw() {
  const layout = {
    margin: { l: 55, r: 10, t: 10, b: 50 },
    xaxis: { title: { text: `closure from ${menus.origin.selectedOptions[0].text} (mm)` }, zeroline: false },
    yaxis: { title: { text: "normal stress (MPa)" }, rangemode: "tozero", zeroline: false },
    hovermode: "closest",
    hoverlabel: { namelength: -1 },
    legend: { orientation: "h", y: -0.18, yanchor: "top" },
    font: { family: "inherit", color: "#1b1f24" },
  };
  Plotly.react("explorer", traces(), layout, OPTIONS);
  fillTable();
}

fill(menus.rock, data.rocks.map((one, i) => [i, one.title]));
fill(menus.cycle, data.cycles.length > 1 ? [[ALL, "all"], ...data.cycles.map((c) => [c, c])] : [[ALL, data.cycles[0]]]);
menus.rock.addEventListener("change", () => { fillParameters(); fillLevels(); draw(); });
menus.parameter.addEventListener("change", () => { menus.level.value = ALL; fillLevels(); draw(); });
["level", "cycle", "origin"].forEach((name) => menus[name].addEventListener("change", draw));
document.getElementById("explorer-choices").addEventListener("submit", (event) => event.preventDefault());
fillParameters();
fillLevels();
draw();
