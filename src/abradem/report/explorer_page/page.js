// What is seen and moved: sliders and typed values, numbers, map, curves, warnings, command.
"use strict";

(() => {
  const { data } = Model;
  const byName = Object.fromEntries(data.quantities.map((one) => [one.name, one]));
  const at = (id) => document.getElementById(id);
  const POINTS = 61;
  const SMALL_POINTS = 25;
  const NEAREST = 5;
  const USUAL_LEVELS = [0.5, 0.8, 0.9, 0.95, 0.99];
  const BLUE = "#005f95";
  const BAND = "rgba(0, 95, 149, 0.18)";
  const FONT = { family: 'system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif', size: 13, color: "#1b1b1b" };
  const SETTINGS = { displayModeBar: false, responsive: true };
  const state = { values: {}, confidence: 0.95, depth: 5, against: "plate_angle", place: 0, top: 0 };

  const element = (tag, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  };
  const short = (number, digits = 4) => {
    if (Number.isNaN(number)) return "none";
    if (!Number.isFinite(number)) return "any number of";
    const rounded = Number(Number(number).toPrecision(digits));
    const size = Math.abs(rounded);
    const plain = size === 0 || (size >= 1e-4 && size < 1e7);
    return plain ? String(rounded) : rounded.toExponential().replace("e+", "e");
  };
  const unitText = (unit) =>
    ({ 1: "", deg: "°", "kg/m3": "kg/m³" })[unit] ?? unit;
  const shown = ({ factor }, value) =>
    Number((factor < 1 ? value * Math.round(1 / factor) : value / factor).toPrecision(12));
  const inUnit = ({ factor }, number) =>
    factor < 1 ? number / Math.round(1 / factor) : number * factor;
  const percent = (level) => `${short(100 * level)} %`;

  // A round step, some two hundred of which make up the range.
  function step(one) {
    const width = shown(one, one.high) - shown(one, one.low);
    const power = 10 ** Math.floor(Math.log10(width / 200));
    return [1, 2, 5, 10].map((digit) => digit * power).find((size) => width / size <= 250);
  }

  function middle(one) {
    if (one.fixed) return one.low;
    if (one.decades) return Number(Math.sqrt(one.low * one.high).toPrecision(2));
    const size = step(one);
    const half = 0.5 * (shown(one, one.low) + shown(one, one.high));
    return inUnit(one, Number((Math.round(half / size) * size).toPrecision(12)));
  }

  // ---- Sliders and typed values ----

  const fields = {};

  function build() {
    const narrow = matchMedia("(max-width: 820px)").matches;
    data.sections.forEach(({ name, quantities }, place) => {
      const group = element("details", { open: !narrow || place < 2 }, element("summary", { textContent: name }));
      quantities.forEach((key) => group.append(row(byName[key])));
      at("quantities").append(group);
    });
  }

  function row(one) {
    const id = `value-${one.name}`;
    const text = element("input", { type: "text", id, autocomplete: "off", spellcheck: false });
    text.setAttribute("aria-describedby", `problem-${one.name}`);
    const label = element("label", { htmlFor: id, textContent: one.label });
    const unit = element("span", { className: "unit", textContent: unitText(one.shown_unit) });
    const slider = element("input", { type: "range", id: `slider-${one.name}`, disabled: one.fixed });
    slider.setAttribute("aria-label", `${one.label}, slider`);
    if (one.decades) {
      Object.assign(slider, { min: Math.log10(one.low), max: Math.log10(one.high), step: 0.01 });
    } else if (!one.fixed) {
      const size = step(one);
      const ends = [Math.ceil(shown(one, one.low) / size), Math.floor(shown(one, one.high) / size)];
      Object.assign(slider, { min: ends[0] * size, max: ends[1] * size, step: size });
    }
    const problem = element("span", { className: "problem", id: `problem-${one.name}` });
    problem.setAttribute("role", "alert");
    slider.addEventListener("input", () => {
      const position = Number(slider.value);
      const value = one.decades
        ? Number((10 ** position).toPrecision(3))
        : inUnit(one, Number(position.toPrecision(12)));
      select(one.name);
      set(one.name, value, slider);
      update();
    });
    text.addEventListener("change", () => {
      const { value, line } = parsed(one, text.value);
      problem.textContent = line ?? "";
      text.setAttribute("aria-invalid", String(Boolean(line)));
      if (line) return;
      select(one.name);
      set(one.name, value);
      update();
    });
    fields[one.name] = { text, slider, problem };
    return element("div", { className: "quantity" }, label, text, unit, slider, problem);
  }

  // The value of a text in the unit of the quantity, or a line on why there is none.
  function parsed(one, text) {
    const plain = text.trim().replace(/[−–]/g, "-").replace(/[µμ]/g, "u").replace("°", "deg")
      .replace(/³/g, "3").replace(/²/g, "2").replace(/·/g, " ");
    const found = /^([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)$/.exec(plain);
    const units = Object.keys(one.units);
    const allowed = units.length ? `allowed ${units.join(", ")}` : "it is a pure number";
    if (!found) return { line: `${text.trim() || "nothing"} is not a number` };
    const [, digits, unit] = found;
    const bare = (name) => name.replace(/[\s^]/g, "");
    const known = units.find((name) => bare(name) === bare(unit));
    if (unit && !known) return { line: `unit ${unit} is unknown (${allowed})` };
    const number = Number(digits);
    let value = inUnit(one, number);
    if (known) {
      const factor = one.units[known];
      // 7 / 1000 is the number nearest to 0.007; 7 * 0.001 need not be.
      const whole = Math.round(1 / factor);
      value = factor < 1 && Math.abs(whole * factor - 1) < 1e-12 ? number / whole : number * factor;
    }
    const [low, high] = one.limits;
    if (!(value >= low && value <= high)) {
      const ends = `${short(shown(one, low))} ... ${short(shown(one, high))} ${unitText(one.shown_unit)}`;
      return { line: `${text.trim()} is impossible (allowed ${ends.trim()})` };
    }
    return { value };
  }

  function set(name, value, moved = null) {
    const one = byName[name];
    const { text, slider, problem } = fields[name];
    state.values[name] = value;
    text.value = short(shown(one, value), 6);
    text.removeAttribute("aria-invalid");
    problem.textContent = "";
    if (slider !== moved) slider.value = one.decades ? Math.log10(value) : shown(one, value);
    slider.setAttribute("aria-valuetext", `${text.value} ${unitText(one.shown_unit)}`.trim());
  }

  function setAll(values) {
    Object.entries(values).forEach(([name, value]) => set(name, value));
    update();
  }

  // ---- Numbers ----

  function drawNumbers(predictions) {
    const level = percent(state.confidence);
    const [first] = predictions;
    at("headline-rate").textContent = `${short(first.rate)} mm/s`;
    at("headline-place").textContent = Model.rates[0].place.toLowerCase();
    at("headline-interval").textContent =
      `${level} interval ${short(first.lower)} to ${short(first.upper)} mm/s`;
    document.querySelectorAll("#rates .interval").forEach((cell) => {
      cell.textContent = `${level} interval`;
    });
    at("hours-header").textContent = `Hours to ${short(state.depth)} mm`;
    const body = document.querySelector("#rates tbody");
    body.replaceChildren(
      ...predictions.map(({ rate, lower, upper }, place) => {
        const { name, place: words } = Model.rates[place];
        const hours = [rate, upper, lower].map((one) => state.depth / one / 3600);
        const line = element(
          "tr", { className: place ? "" : "target" },
          element("td", { textContent: words }),
          element("td", { textContent: short(rate) }),
          element("td", { textContent: `${short(lower, 3)} to ${short(upper, 3)}` }),
          element("td", { textContent: short(hours[0]) }),
          element("td", { textContent: `${short(hours[1], 3)} to ${short(hours[2], 3)}` }),
        );
        Object.assign(line.dataset, { name, rate, lower, upper, hours: hours[0] });
        return line;
      }),
    );
  }

  function drawWarnings() {
    const { quantities, far } = Model.outside(state.values);
    const lines = quantities.map((one) => {
      const unit = unitText(one.shown_unit);
      const value = `${one.label} ${short(shown(one, state.values[one.name]))} ${unit}`.trim();
      const [low, high] = [one.low, one.high].map((end) => short(shown(one, end)));
      return one.fixed
        ? `${value}: held fixed at ${`${low} ${unit}`.trim()} in training. Its effect is unknown; the interval does not hold.`
        : `${value} is outside the training range ${`${low} ... ${high} ${unit}`.trim()}: extrapolated; the interval does not hold.`;
    });
    if (far) lines.push("This case is far from all training cases: extrapolated; the interval may not hold.");
    at("warnings").replaceChildren(...lines.map((line) => element("p", { textContent: line })));
  }

  // ---- Map ----

  function drawMap(predictions) {
    if (!Model.maps) return;
    const { counts: [nx, nz], plate, measure } = Model.maps;
    const mean = Model.rates.findIndex(({ name }) => name === `wear_${measure}_mean`);
    const rates = Model.wearMap(state.values, mean < 0 ? null : predictions[mean].rate);
    const centres = (count, length) =>
      Array.from({ length: count }, (_, place) => 1000 * length * ((place + 0.5) / count - 0.5));
    const [x, z] = [centres(nx, plate[0]), centres(nz, plate[1])];
    const worst = rates.reduce((best, one, place) => (one > rates[best] ? place : best), 0);
    const largest = rates[worst];
    if (!at("keep-scale").checked || !state.top) state.top = largest;
    const grid = z.map((_, across) => x.map((_, along) => rates[along * nz + across]));
    at("map").dataset.rates = JSON.stringify(Array.from(rates));
    Plotly.react("map", [
      {
        type: "heatmap", x, y: z, z: grid, colorscale: "Cividis", zmin: 0, zmax: state.top,
        colorbar: { title: { text: "mm/s", side: "right" }, thickness: 14, exponentformat: "power", tickfont: { size: 11 } },
        hovertemplate: "x %{x:.0f} mm, z %{y:.0f} mm<br>%{z:.4g} mm/s<extra></extra>",
      },
    ], {
      font: FONT, margin: { l: 58, r: 10, t: 8, b: 48 },
      xaxis: { title: { text: "Up the slope (mm)" }, constrain: "domain", fixedrange: true },
      yaxis: { title: { text: "Across (mm)" }, scaleanchor: "x", constrain: "domain", fixedrange: true },
    }, SETTINGS);
    const average = rates.reduce((a, b) => a + b, 0) / rates.length;
    const place = `x = ${short(x[Math.floor(worst / nz)], 3)} mm`;
    at("map").setAttribute("aria-label", `Wear map: mean ${short(average)} mm/s, most worn at ${place}`);
    at("map-note").textContent =
      `Mean ${short(average)} mm/s; most worn element ${short(largest)} mm/s at ${place}. It is the wear of a long time; that of a simulation of seconds scatters about it and has larger extremes.` +
      quality();
    const header = element("tr", {}, element("th", { textContent: "x \\ z (mm)" }),
      ...z.map((one) => element("th", { textContent: short(one, 4) })));
    at("map-table").replaceChildren(header, ...x.map((one, along) =>
      element("tr", {}, element("th", { textContent: short(one, 4) }),
        ...z.map((_, across) => element("td", { textContent: short(rates[along * nz + across], 3) })))));
  }

  function quality() {
    const { shape_R2: shape, shape_R2_possible: possible, maximum_ratio: ratio } = Model.maps.scores;
    if ([shape, possible, ratio].includes(undefined)) return "";
    return ` On held-out cases: R² of the shape ${short(shape, 2)}, where the scatter of the simulations allows ${short(possible, 2)}; most worn element ${short(ratio, 2)} of the simulated one.`;
  }

  // ---- Curves ----

  function sweep(one, rate, count) {
    const values = Array.from({ length: count }, (_, place) => {
      const share = place / (count - 1);
      return one.decades
        ? one.low * (one.high / one.low) ** share
        : one.low + share * (one.high - one.low);
    });
    const found = values.map(
      (value) => Model.predict({ ...state.values, [one.name]: value }, state.confidence, [rate])[0],
    );
    return { x: values.map((value) => shown(one, value)), found };
  }

  function traces(one, rate, count, axes, here) {
    const { x, found } = sweep(one, rate, count);
    const upper = found.map((point) => (Number.isFinite(point.upper) ? point.upper : null));
    return [
      { x, y: found.map(({ lower }) => lower), mode: "lines", line: { width: 0 }, hoverinfo: "skip", ...axes },
      { x, y: upper, mode: "lines", line: { width: 0 }, fill: "tonexty", fillcolor: BAND, hoverinfo: "skip", ...axes },
      { x, y: found.map((point) => point.rate), mode: "lines", line: { color: BLUE, width: 2 }, hovertemplate: "%{x:.4g}: %{y:.4g} mm/s<extra></extra>", ...axes },
      { x: [shown(one, state.values[one.name])], y: [here], mode: "markers", marker: { color: "#d55e00", size: 8, symbol: "diamond" }, hoverinfo: "skip", ...axes },
    ];
  }

  const title = (one) => {
    const unit = unitText(one.shown_unit);
    return unit ? `${one.label} (${unit})` : one.label;
  };

  function drawCurve(predictions) {
    const one = byName[state.against];
    if (!one) return;
    const rate = Model.rates[state.place];
    const log = at("log-axis").checked;
    Plotly.react("curve", traces(one, rate, POINTS, {}, predictions[state.place].rate), {
      font: FONT, margin: { l: 70, r: 12, t: 8, b: 48 }, showlegend: false,
      xaxis: { title: { text: title(one) }, type: one.decades ? "log" : "linear", fixedrange: true },
      yaxis: { title: { text: "wear depth rate (mm/s)" }, type: log ? "log" : "linear", automargin: true, rangemode: "tozero", exponentformat: "power", fixedrange: true },
    }, SETTINGS);
    at("curve").setAttribute("aria-label",
      `${rate.place} against ${one.label}, with ${percent(state.confidence)} intervals; now ${short(predictions[state.place].rate)} mm/s`);
  }

  const columnsOfCurves = () => Math.max(2, Math.min(5, Math.floor(at("curves").clientWidth / 190)));

  // The title of a small panel: words on lines of at most so many letters, the unit on its own.
  function lines(one, letters) {
    const found = [""];
    for (const word of one.label.split(" ")) {
      const last = found.length - 1;
      if (found[last] && `${found[last]} ${word}`.length > letters) found.push(word);
      else found[last] = `${found[last]} ${word}`.trim();
    }
    const unit = unitText(one.shown_unit);
    return unit ? [...found, `(${unit})`] : found;
  }

  function drawCurves(predictions) {
    const varied = data.quantities.filter(({ fixed }) => !fixed);
    const columns = columnsOfCurves();
    const rows = Math.ceil(varied.length / columns);
    // A letter is some 6 px wide; axis and curve take 111 px, tick labels 36, a line of a title 14.
    const letters = Math.floor((at("curves").clientWidth - 60) / columns / 6);
    const titles = varied.map((one) => lines(one, letters));
    const under = 36 + 14 * Math.max(...titles.map(({ length }) => length));
    const height = 111 + under;
    const rate = Model.rates[state.place];
    const layout = {
      font: { ...FONT, size: 11 }, showlegend: false, height: height * rows + 20,
      margin: { l: 52, r: 8, t: 6, b: 10 }, annotations: [],
    };
    const all = [];
    varied.forEach((one, place) => {
      const number = place ? place + 1 : "";
      const [column, line] = [place % columns, Math.floor(place / columns)];
      const gap = 0.02;
      const left = column / columns + (column ? gap / 2 : 0);
      const top = 1 - line / rows;
      layout[`xaxis${number}`] = {
        domain: [left, (column + 1) / columns - gap / 2], anchor: `y${number}`, fixedrange: true, nticks: 4,
        type: one.decades ? "log" : "linear", title: { text: titles[place].join("<br>"), standoff: 2, font: { size: 11 } },
        ...(one.decades ? { dtick: 1 } : {}), exponentformat: "power",
      };
      layout[`yaxis${number}`] = {
        domain: [top - 1 / rows + under / (height * rows), top - 0.01], anchor: `x${number}`, fixedrange: true,
        type: "log", dtick: 1, exponentformat: "power", showticklabels: column === 0,
        ...(place ? { matches: "y" } : {}),
      };
      const axes = { xaxis: `x${number}`, yaxis: `y${number}` };
      all.push(...traces(one, rate, SMALL_POINTS, axes, predictions[state.place].rate));
    });
    Plotly.react("curves", all, layout, { ...SETTINGS, staticPlot: true });
    at("curves").dataset.columns = columns;
    at("curves").setAttribute("aria-label", `${rate.place} against each of ${varied.length} quantities`);
  }

  // ---- Nearest cases and command ----

  function drawNearest() {
    const columns = data.beside.map((name) => byName[name]);
    const found = Model.nearestCases(state.values, NEAREST);
    document.querySelector("#nearest thead").replaceChildren(element("tr", {},
      ...["Case", "Distance", "Simulated (mm/s)", "Predicted (mm/s)", ...columns.map(title), ""].map((text) =>
        element("th", { scope: "col", textContent: text }))));
    document.querySelector("#nearest tbody").replaceChildren(...found.map(({ id, row: place, distance, rate }) => {
      const values = Model.caseValues(place);
      const predicted = Model.predict(values, state.confidence, [Model.rates[0]])[0].rate;
      const take = element("button", { type: "button", textContent: "Set", title: `Set all values of case ${id}` });
      take.setAttribute("aria-label", take.title);
      take.addEventListener("click", () => setAll(values));
      return element("tr", {},
        ...[id, short(distance, 3), short(rate), short(predicted), ...columns.map((one) => short(shown(one, values[one.name]), 4))]
          .map((text) => element("td", { textContent: text })),
        element("td", {}, take));
    }));
  }

  function drawCommand() {
    // 22.6 mm are 0.0226 m, and not 0.022600000000000002, as a processor divides.
    const values = data.quantities.map(({ name }) => `${name}=${Number(state.values[name].toPrecision(15))}`);
    const options = [`--model ${data.model}`, `--confidence ${state.confidence}`, `--depth ${state.depth}mm`];
    if (Model.maps) options.push("--map map.png");
    at("command").textContent = ["abradem predict", ...values, ...options].join(" \\\n  ");
  }

  // ---- Together ----

  let waiting = false;
  let idle = 0;

  function drawFirst() {
    if (!waiting) return;
    waiting = false;
    const predictions = Model.predict(state.values, state.confidence);
    drawNumbers(predictions);
    drawWarnings();
    drawMap(predictions);
    drawCurve(predictions);
    drawCommand();
  }

  function drawRest() {
    drawFirst();
    drawCurves(Model.predict(state.values, state.confidence));
    drawNearest();
    document.body.dataset.state = "drawn";
  }

  // Numbers, map and curve follow a slider at once, the rest when it rests.
  function update() {
    document.body.dataset.state = "waiting";
    clearTimeout(idle);
    idle = setTimeout(drawRest, 150);
    if (!waiting) requestAnimationFrame(drawFirst);
    waiting = true;
  }

  function select(name) {
    if (byName[name].fixed) return;
    state.against = name;
    at("against").value = name;
  }

  function options(select, entries, chosen) {
    select.replaceChildren(...entries.map(([value, textContent]) =>
      element("option", { value, textContent, selected: value === chosen })));
  }

  function start() {
    at("study").textContent = data.study;
    at("about").textContent =
      `Predictions of the surrogate that learned from ${data.training_rows ?? data.cases.ids.length} cases. Everything is computed in this page.`;
    at("about").textContent += data.jet_known
      ? " Feed, factory patch, fall height, plate and contacts between particles have no sliders: they are those of the study, and another study has others."
      : " The jet behind the cases is not known; answers are for it alone.";
    build();
    const highest = Model.highestLevel();
    const levels = USUAL_LEVELS.filter((level) => level <= highest);
    if (!levels.includes(0.95)) levels.push(highest);
    state.confidence = levels.includes(0.95) ? 0.95 : highest;
    options(at("level"), levels.map((level) => [String(level), percent(level)]), String(state.confidence));
    options(at("preset"), [["", "as set"], ...Object.keys(data.presets).map((name) => [name, `${name.replaceAll("_", " ")} on steel`])], "");
    options(at("against"), data.quantities.filter(({ fixed }) => !fixed).map((one) => [one.name, one.label]), state.against);
    state.against = at("against").value;
    options(at("curve-place"), Model.rates.map(({ place }, number) => [String(number), place]), "0");
    if (!Model.maps) at("map-section").hidden = true;

    at("level").addEventListener("change", () => { state.confidence = Number(at("level").value); update(); });
    at("depth").addEventListener("change", () => {
      const depth = Number(at("depth").value.replace(/\s*mm$/, ""));
      const valid = depth > 0 && Number.isFinite(depth);
      at("depth").setAttribute("aria-invalid", String(!valid));
      if (valid) { state.depth = depth; update(); }
    });
    at("preset").addEventListener("change", () => setAll(data.presets[at("preset").value] ?? {}));
    at("reset").addEventListener("click", () => {
      at("preset").value = "";
      setAll(Object.fromEntries(data.quantities.map((one) => [one.name, middle(one)])));
    });
    at("against").addEventListener("change", () => { state.against = at("against").value; update(); });
    at("curve-place").addEventListener("change", () => { state.place = Number(at("curve-place").value); update(); });
    for (const id of ["log-axis", "keep-scale"]) at(id).addEventListener("change", update);
    at("controls").addEventListener("submit", (event) => event.preventDefault());
    at("copy").addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(at("command").textContent);
        at("copied").textContent = "copied";
      } catch {
        getSelection().selectAllChildren(at("command"));
        at("copied").textContent = "selected; press Ctrl+C";
      }
    });
    // A telephone that is turned has room for another number of panels.
    addEventListener("resize", () => {
      if (Number(at("curves").dataset.columns) !== columnsOfCurves()) update();
    });
    setAll(Object.fromEntries(data.quantities.map((one) => [one.name, middle(one)])));
  }

  start();
})();
