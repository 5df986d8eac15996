// The scene: particles as spheres, the wear of the surface as colours, played and turned.
"use strict";

(() => {
  const at = (id) => document.getElementById(id);
  const data = JSON.parse(at("data").textContent);
  const MM = 1000;
  const FONT = { family: 'system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif', size: 12, color: "#1b1b1b" };
  const FACTORY = "#0072b2";
  const GOLDEN = 0.618034;
  const SEEN_THROUGH = 0.3;
  const FEW = 1500;
  const SPEEDS = { "real time": 1, "2 times slower": 2, "5 times slower": 5, "10 times slower": 10 };
  const UP = { x: 0, y: 1, z: 0 };
  const VIEWS = {
    oblique: { x: -0.52, y: 0.75, z: 1.35 },
    "along z": { x: 0, y: 0.05, z: 1.65 },
    "along x": { x: -1.65, y: 0.05, z: 0.01 },
    "from above": { x: 0, y: 1.65, z: 0.01 },
  };
  // Room for the colour bar, px.
  const BELOW = 74;
  const state = { frame: 0, playing: false, view: "oblique" };

  const KINDS = { f4: Float32Array, f8: Float64Array };
  function unpacked({ type, text }) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return new KINDS[type](bytes.buffer);
  }
  const short = (number) => String(Number(number.toPrecision(3))).replace("e+", "e");
  const times = unpacked(data.times);
  const counts = unpacked(data.counts);
  const places = unpacked(data.places);
  const identities = unpacked(data.identities);
  const vertices = unpacked(data.vertices);
  const triangles = unpacked(data.triangles);
  const depth = unpacked(data.depth);
  const cells = data.depth.shape[1];
  const starts = [0];
  counts.forEach((count) => starts.push(starts[starts.length - 1] + count));
  const size = data.radius * MM;

  // A sphere of radius 1: an icosahedron, divided once unless there are many particles.
  function sphere(divided) {
    const t = (1 + Math.sqrt(5)) / 2;
    const points = [
      [-1, t, 0], [1, t, 0], [-1, -t, 0], [1, -t, 0], [0, -1, t], [0, 1, t],
      [0, -1, -t], [0, 1, -t], [t, 0, -1], [t, 0, 1], [-t, 0, -1], [-t, 0, 1],
    ];
    let faces = [
      [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4],
      [11, 10, 2], [10, 7, 6], [7, 1, 8], [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8],
      [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    if (divided) {
      const known = {};
      const middle = (a, b) => {
        const key = a < b ? `${a} ${b}` : `${b} ${a}`;
        known[key] ??= points.push(points[a].map((one, axis) => one + points[b][axis])) - 1;
        return known[key];
      };
      faces = faces.flatMap(([a, b, c]) => {
        const [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        return [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]];
      });
    }
    return { points: points.map((one) => one.map((part) => part / Math.hypot(...one))), faces };
  }
  const BALL = sphere(Math.max(...counts) <= FEW);
  // Slightly different greys, so that particles can be told apart.
  const shade = (identity) => {
    const grey = Math.round(120 + 70 * ((identity * GOLDEN) % 1));
    return `rgb(${grey},${grey},${grey + 6})`;
  };

  function within(place) {
    return [0, 1, 2].every(
      (axis) =>
        places[3 * place + axis] - data.radius >= data.box[0][axis] &&
        places[3 * place + axis] + data.radius <= data.box[1][axis],
    );
  }

  function particles(frame) {
    const made = { x: [], y: [], z: [], i: [], j: [], k: [], vertexcolor: [] };
    let count = 0;
    for (let place = starts[frame]; place < starts[frame + 1]; place += 1) {
      if (!within(place)) continue;
      const colour = shade(identities[place]);
      const first = made.x.length;
      count += 1;
      for (const [x, y, z] of BALL.points) {
        made.x.push(places[3 * place] * MM + size * x);
        made.y.push(places[3 * place + 1] * MM + size * y);
        made.z.push(places[3 * place + 2] * MM + size * z);
        made.vertexcolor.push(colour);
      }
      for (const [a, b, c] of BALL.faces) {
        made.i.push(first + a);
        made.j.push(first + b);
        made.k.push(first + c);
      }
    }
    return {
      count,
      trace: {
        type: "mesh3d", ...made, visible: count > 0 && at("particles").checked, hoverinfo: "skip", flatshading: false,
        lighting: { ambient: 0.55, diffuse: 0.6, specular: 0.15, roughness: 0.6 },
        lightposition: { x: -2000, y: 6000, z: 4000 },
      },
    };
  }

  const column = (array, axis, scale) =>
    Array.from({ length: array.length / 3 }, (_, row) => array[3 * row + axis] * scale);
  const SURFACE = {
    type: "mesh3d", hoverinfo: "skip", flatshading: true,
    x: column(vertices, 0, MM), y: column(vertices, 1, MM), z: column(vertices, 2, MM),
    i: column(triangles, 0, 1), j: column(triangles, 1, 1), k: column(triangles, 2, 1),
    // No light and shade, so that a colour is that of the scale.
    lighting: { ambient: 1, diffuse: 0, specular: 0, fresnel: 0 },
  };
  const perCell = SURFACE.i.length / cells;
  const colourOf = (worn) =>
    worn > 0
      ? data.colours[Math.min(Math.floor((worn / data.top) * data.colours.length), data.colours.length - 1)]
      : data.no_wear;
  // Positions of the vertices at a time: turning parts turn about their axes (Rodrigues).
  function positions(time) {
    const { x, y, z } = SURFACE;
    if (!data.turning.length) return { x, y, z };
    const moved = { x: [...x], y: [...y], z: [...z] };
    for (const { spin, point, direction, vertices: turned } of data.turning) {
      const [cos, sin] = [Math.cos(spin * time), Math.sin(spin * time)];
      const [a, b, c] = direction;
      for (const one of turned) {
        const [u, v, w] = [x[one] - point[0] * MM, y[one] - point[1] * MM, z[one] - point[2] * MM];
        const along = (a * u + b * v + c * w) * (1 - cos);
        moved.x[one] = point[0] * MM + along * a + cos * u + sin * (b * w - c * v);
        moved.y[one] = point[1] * MM + along * b + cos * v + sin * (c * u - a * w);
        moved.z[one] = point[2] * MM + along * c + cos * w + sin * (a * v - b * u);
      }
    }
    return moved;
  }

  // The surface as traces: of a geometry the cells with wear, and, seen through, those without.
  function surface(frame) {
    const placed = { ...SURFACE, ...positions(times[frame]) };
    const groups = data.see_through ? [[], []] : [[]];
    for (let cell = 0; cell < cells; cell += 1) {
      groups[data.see_through && !(depth[frame * cells + cell] > 0) ? 1 : 0].push(cell);
    }
    return groups.map((chosen, place) => {
      const trace = { ...placed, i: [], j: [], k: [], facecolor: [], opacity: place === 1 ? SEEN_THROUGH : 1 };
      for (const cell of chosen) {
        const colour = colourOf(depth[frame * cells + cell]);
        for (let part = cell * perCell; part < (cell + 1) * perCell; part += 1) {
          trace.i.push(SURFACE.i[part]);
          trace.j.push(SURFACE.j[part]);
          trace.k.push(SURFACE.k[part]);
          trace.facecolor.push(colour);
        }
      }
      return { ...trace, visible: chosen.length > 0 };
    });
  }

  const corners = [...data.factory, data.factory[0]];
  const FEED = {
    type: "scatter3d", mode: "lines", hoverinfo: "skip", showlegend: false,
    line: { color: FACTORY, width: 4 },
    x: corners.map((one) => one[0] * MM), y: corners.map((one) => one[1] * MM), z: corners.map((one) => one[2] * MM),
  };
  const power = Math.floor(Math.log10(data.top));
  const unit = power === 0 ? "mm" : `10<sup>${power}</sup> mm`.replace("-", "\u2212");
  // An unseen point, whose colour bar is that of the surface.
  const SCALE = {
    type: "scatter3d", mode: "markers", hoverinfo: "skip", showlegend: false,
    x: [SURFACE.x[0]], y: [SURFACE.y[0]], z: [SURFACE.z[0]],
    marker: {
      size: 0.1, opacity: 0, color: [0], cmin: 0, cmax: data.top / 10 ** power,
      colorscale: data.colours.map((colour, place) => [place / (data.colours.length - 1), colour]),
      colorbar: {
        orientation: "h", x: 0.5, y: 0, yanchor: "top", len: 0.8, thickness: 12, outlinewidth: 0.6,
        title: { text: `Wear depth (${unit})`, side: "bottom" },
      },
    },
  };

  const ranges = [0, 1, 2].map((axis) => [data.box[0][axis] * MM, data.box[1][axis] * MM]);
  const spans = ranges.map(([low, high]) => high - low);
  // Equal axes, with the diagonal of a cube of edge 1, so that a long box is not small, nor cut.
  const unitLength = Math.max(Math.hypot(...spans) / Math.sqrt(3), Math.max(...spans) / 1.2);
  const axis = (place, text) => ({
    range: ranges[place], autorange: false, title: { text }, showspikes: false, nticks: 5,
    gridcolor: "#dddddd", zeroline: false, showbackground: false,
  });
  // From so far away that the titles of the axes are seen; of a narrow screen the width decides.
  function eye() {
    const { clientWidth: width, clientHeight: height } = at("view");
    const away = 1.45 * Math.max(1, 1.1 * (height - BELOW) / width);
    return Object.fromEntries(Object.entries(VIEWS[state.view]).map(([name, one]) => [name, one * away]));
  }
  function layout() {
    return {
      margin: { l: 0, r: 0, t: 0, b: BELOW }, font: FONT, paper_bgcolor: "#ffffff", showlegend: false,
      uirevision: state.view,
      scene: {
        uirevision: state.view, dragmode: "orbit",
        xaxis: axis(0, "x (mm)"), yaxis: axis(1, "height (mm)"), zaxis: axis(2, "z (mm)"),
        aspectmode: "manual",
        aspectratio: { x: spans[0] / unitLength, y: spans[1] / unitLength, z: spans[2] / unitLength },
        camera: { up: UP, eye: eye(), center: { x: 0, y: -0.12, z: 0 } },
      },
    };
  }

  const canvas = document.createElement("canvas");
  const drawable = Boolean(canvas.getContext("webgl2") ?? canvas.getContext("webgl"));

  async function draw() {
    const { frame } = state;
    document.body.dataset.state = "drawing";
    const { count, trace } = particles(frame);
    const worn = depth.subarray(frame * cells, (frame + 1) * cells);
    const deepest = worn.reduce((most, one) => Math.max(most, one), 0);
    const untouched = worn.reduce((sum, one) => sum + (one > 0 ? 0 : 1), 0);
    const present = counts[frame];
    const clock = `${times[frame].toFixed(2)} s`;
    at("clock").textContent = `${clock} of ${times[times.length - 1].toFixed(2)} s`;
    at("time").value = frame;
    at("time").setAttribute("aria-valuetext", clock);
    const left = present > count ? `, ${present - count} of them outside the box and not drawn` : "";
    at("words").textContent =
      `At ${clock}: ${present} particles of ${short(size)} mm radius${left}; deepest wear ` +
      `${short(deepest)} mm; ${untouched} of ${cells} ${data.cell} without wear.`;
    at("view").setAttribute("aria-label", `3-D view. ${at("words").textContent}`);
    if (drawable) {
      await Plotly.react(at("view"), [...surface(frame), trace, FEED, SCALE], layout(), {
        displayModeBar: false, responsive: true, scrollZoom: true,
      });
    }
    document.body.dataset.state = "drawn";
  }

  function show(frame) {
    state.frame = frame;
    return draw();
  }

  function stop() {
    state.playing = false;
    at("play").textContent = "Play";
  }
  async function play() {
    state.playing = true;
    at("play").textContent = "Pause";
    const last = times.length - 1;
    if (state.frame === last) await show(0);
    let before = performance.now();
    let time = times[state.frame];
    const step = async (now) => {
      if (!state.playing) return;
      time += Math.max(now - before, 0) / 1000 / SPEEDS[at("speed").value];
      before = now;
      let next = state.frame;
      while (next < last && times[next + 1] <= time) next += 1;
      if (next !== state.frame) await show(next);
      if (next === last) stop();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  at("study").textContent = `study ${data.study}`;
  at("about").textContent =
    `The typical case: ${data.about}. Wear measure: ${data.measure}.` +
    (times.length < data.snapshots ? ` ${times.length} of ${data.snapshots} snapshots.` : "");
  at("swatch").style.background = data.no_wear;
  at("deeper").textContent = `deeper than ${short(data.top)} mm: the darkest colour`;
  at("patch").style.border = `2px solid ${FACTORY}`;
  at("time").max = times.length - 1;
  for (const name of Object.keys(SPEEDS)) at("speed").append(new Option(name, name));
  at("speed").value = "5 times slower";
  for (const name of Object.keys(VIEWS)) at("camera").append(new Option(name, name));
  at("time").addEventListener("input", () => {
    stop();
    show(Number(at("time").value));
  });
  at("play").addEventListener("click", () => (state.playing ? stop() : play()));
  at("camera").addEventListener("change", () => {
    state.view = at("camera").value;
    draw();
  });
  at("particles").addEventListener("change", draw);
  at("controls").addEventListener("submit", (event) => event.preventDefault());
  if (!drawable) {
    at("view").className = "without";
    at("view").textContent = "This browser has no WebGL, which the 3-D view needs. The text below says what it would show.";
  }
  // First what a reader comes for: the worn surface, at the end.
  show(times.length - 1);
})();
