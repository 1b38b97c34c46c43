// The interactive view: plotly draws; this reads the data, and connects the slider, the toggles and the branch table.
"use strict";
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const types = { int16: Int16Array, uint16: Uint16Array, int32: Int32Array, float32: Float32Array };
  const byId = (id) => document.getElementById(id);

  function decode(encoded) {
    const bytes = Uint8Array.from(atob(encoded.data), (letter) => letter.charCodeAt(0));
    return new types[encoded.dtype](bytes.buffer);
  }

  // (n, 3) numbers, row by row, as the three coordinates of a trace
  function coordinates(encoded, rows) {
    const flat = decode(encoded);
    const chosen = rows || Array.from({ length: flat.length / 3 }, (_, row) => row);
    const axis = (k) => Float32Array.from(chosen, (row) => (row < 0 ? NaN : flat[3 * row + k] / encoded.scale));
    return { x: axis(0), y: axis(1), z: axis(2) };
  }

  function corners(encoded) {
    const flat = decode(encoded);
    const corner = (k) => Int32Array.from({ length: flat.length / 3 }, (_, row) => flat[3 * row + k]);
    return { i: corner(0), j: corner(1), k: corner(2) };
  }

  performance.mark("library");
  const traces = [];
  const layers = {}; // from the name of a toggle to the numbers of its traces
  const later = []; // layers and numbers of traces that are added after the first frame

  const isShown = (layer) => { const box = byId("show-" + layer); return box ? box.checked : true; };

  function add(layer, trace) {
    (layers[layer] = layers[layer] || []).push(traces.length);
    traces.push({ showlegend: false, hoverinfo: "skip", visible: isShown(layer), ...trace });
    return traces.length - 1;
  }

  // the symbols of markers and the programs that draw them take a fifth of the time to the first frame
  function addLater(layer, trace) {
    later.push([layer, traces.length]);
    return add(layer, { ...trace, visible: false });
  }

  const lighting = { ambient: 0.55, diffuse: 0.6, specular: 0.15, roughness: 0.7 };
  const surface = (positions, faces, style) => ({ type: "mesh3d", ...positions, ...faces, lighting, ...style });
  const points = (positions, style) => ({ type: "scatter3d", mode: "markers", ...positions, marker: style });

  function addBalls(nodes, radii, ball) {
    const [unit, faces] = [decode(ball.vertices), decode(ball.faces)];
    const [n, m] = [unit.length / 3, faces.length / 3];
    const positions = { x: [], y: [], z: [] };
    const triangles = { i: [], j: [], k: [] };
    data.skeleton.balls.forEach((node, number) => {
      for (let v = 0; v < n; v += 1) {
        ["x", "y", "z"].forEach((axis, k) => positions[axis].push(nodes[axis][node] + (radii[node] * unit[3 * v + k]) / ball.vertices.scale));
      }
      for (let f = 0; f < m; f += 1) {
        ["i", "j", "k"].forEach((corner, k) => triangles[corner].push(number * n + faces[3 * f + k]));
      }
    });
    add("balls", surface(positions, triangles, { color: "#e8833a", opacity: 0.3 }));
  }

  let branchOfNode = null;
  const branchOfPoint = []; // of the lines
  const paths = data.skeleton ? data.skeleton.branches : [];

  const view = byId("view");
  // lines and markers are made for a view of 640 pixels; on a small one they would hide the shape
  const shrink = Math.min(1, Math.max(0.4, Math.min(view.clientWidth, view.clientHeight) / 640));

  function addSkeleton(skeleton) {
    // and thousands of branches would be hidden by their markers
    const crowd = Math.min(1, Math.sqrt(200 / Math.max(1, paths.length)));
    skeleton.width *= shrink * Math.max(0.5, crowd);
    skeleton.marker *= shrink * crowd;
    const nodes = coordinates(skeleton.nodes);
    const radii = decode(skeleton.radii);
    branchOfNode = new Array(radii.length).fill(-1);
    paths.forEach((path, branch) => path.forEach((node) => { branchOfNode[node] = branch; }));
    skeleton.junctions.forEach((node) => { branchOfNode[node] = -1; });
    const [rows, colors] = [[], []];
    paths.forEach((path, branch) => {
      path.forEach((node) => { rows.push(node); colors.push(radii[node]); branchOfPoint.push(branch); });
      rows.push(-1);
      colors.push(skeleton.low);
      branchOfPoint.push(branch);
    });
    const scale = { colorscale: skeleton.colors, cmin: skeleton.low, cmax: skeleton.high };
    const bar = { title: { text: "radius" }, len: 0.5, thickness: 10, x: 1, xanchor: "right", ypad: 0, tickformat: ".3g" };
    const kind = skeleton.radius_kind.replace(/</g, "&lt;");
    const labels = Array.from(radii, (radius, node) => {
      const seen = [nodes.x[node], nodes.y[node], nodes.z[node]];
      const place = skeleton.center.map((middle, k) => (
        Number((middle + skeleton.size * seen.reduce((sum, value, a) => sum + value * skeleton.axes[a][k], 0)).toPrecision(6)))).join(", ");
      const branch = branchOfNode[node] < 0 ? "junction" : "branch " + branchOfNode[node];
      const length = Number.isNaN(radius) ? "unknown" : String(Number((radius * skeleton.size).toPrecision(4)));
      return `node ${node}<br>${branch}<br>${kind} radius ${length}<br>(${place})`;
    });
    const line = { width: skeleton.width, color: colors, ...scale };
    if (skeleton.high > skeleton.low) {
      Object.assign(line, { colorbar: { ...bar, tickvals: skeleton.ticks, ticktext: skeleton.tick_labels } });
    }
    add("skeleton", { type: "scatter3d", mode: "lines", hoverinfo: "text", ...coordinates(skeleton.nodes, rows),
      text: rows.map((node) => labels[node] || ""), line });
    const shown = { size: skeleton.marker, color: Array.from(radii), ...scale, line: { width: 0 } };
    data.nodeTrace = addLater("skeleton", { ...points(nodes, shown), text: labels, hoverinfo: "text" });
    const picked = (numbers) => coordinates(skeleton.nodes, numbers);
    addLater("tips", points(picked(skeleton.tips), { size: skeleton.marker + 1.5 * crowd, color: "#d62728" }));
    addLater("junctions", points(picked(skeleton.junctions), { size: skeleton.marker + crowd, color: "#1a1a2e", symbol: "square", line: { color: "#ffffff", width: crowd } }));
    addLater("off_center", points(picked(skeleton.off_center), { size: skeleton.marker + 6, color: "#00a0a0", symbol: "circle-open" }));
    if (skeleton.balls.length) addBalls(nodes, radii, data.ball);
    data.selectedTrace = add("selected", { type: "scatter3d", mode: "lines", x: [], y: [], z: [],
      line: { width: skeleton.width + 6, color: "#f2b705" } });
  }

  if (data.mesh) {
    const positions = coordinates(data.mesh.vertices);
    const faces = corners(data.mesh.faces);
    add("mesh", surface(positions, faces, { color: "#a8bad4", opacity: data.skeleton ? 0.35 : 1 }));
    if (data.mesh.field) {
      const bar = { title: { text: data.mesh.field.name.replace(/</g, "&lt;") }, len: 0.5, thickness: 10, x: 1, xanchor: "right", ypad: 0 };
      const [low, high] = [data.mesh.field.low, data.mesh.field.high];
      add("field", surface(positions, faces, { intensity: decode(data.mesh.field), cmin: low, cmax: high,
        colorscale: data.mesh.field.colors, colorbar: bar }));
    }
    if (data.mesh.parts) {
      const colors = data.palette;
      const facecolor = Array.from(decode(data.mesh.parts), (part) => colors[part % colors.length]);
      add("parts", surface(positions, faces, { facecolor, opacity: 0.6 }));
    }
  }
  if (data.cloud) add("mesh", points(coordinates(data.cloud), { size: 1.5, color: "#7f93b2" }));
  if (data.mended) add("mended", points(coordinates(data.mended), { size: 3, color: "#e8833a", symbol: "diamond" }));
  if (data.steps) {
    add("contracted", surface(coordinates(data.steps.positions[0]), corners(data.steps.faces), { color: "#4c78a8", opacity: 0.9 }));
  }
  if (data.skeleton) addSkeleton(data.skeleton);

  const theme = () => {
    const style = getComputedStyle(document.documentElement);
    return { text: style.getPropertyValue("--text").trim(), line: style.getPropertyValue("--line").trim() };
  };
  const axis = { visible: false, range: [-1, 1], autorange: false, title: { text: "" } }; // titles would be drawn, unseen
  // plotly's default, two pixels for each of the screen, takes four times as long to fill; edges are smooth without it
  // newer versions have a button that uploads the chart
  const options = { displaylogo: false, responsive: true, plotGlPixelRatio: Math.min(2, Math.max(1, window.devicePixelRatio)),
    plotlyServerURL: "", modeBarButtonsToRemove: ["sendChartToCloud"] };
  const [width, height, depth] = data.extent; // half the sides of the shape, the largest of which is 1, half a unit here
  const share = data.skeleton ? 1 - 64 / view.clientWidth : 1; // of the width of the view, beside the color bar
  // so far from the nearest part that all is seen: 1.25 shows half a unit above and below, and 5 % of space
  const distance = 1.3 * Math.max(height, width * (view.clientHeight / (share * view.clientWidth))) + depth / 2;
  const layout = {
    template: "none", paper_bgcolor: "rgba(0,0,0,0)", font: { color: theme().text, size: 13 },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: "#888888", activecolor: "#7e03a8" },
    margin: { l: 0, r: 0, b: 0, t: 0 }, hoverlabel: { align: "left" },
    scene: { xaxis: axis, yaxis: axis, zaxis: axis, domain: { x: [0, share] }, aspectmode: "manual", aspectratio: { x: 1, y: 1, z: 1 },
      camera: { eye: { x: 0, y: 0, z: distance }, up: { x: 0, y: 1, z: 0 }, projection: { type: "perspective" } }, dragmode: "orbit" },
  };
  const restyle = (change, numbers) => (numbers && numbers.length ? Plotly.restyle(view, change, numbers) : null);
  performance.mark("decoded");

  // The pointer is for the nodes and lines of the skeleton: what lies in front of them would take it. In plotly such a
  // trace keeps it from those behind and only shows no label, so it is left out of the picture for the pointer.
  function letPointerThrough() {
    const scene = view._fullLayout.scene._scene;
    Object.values(scene.traces).filter((trace) => trace.data.hoverinfo === "skip").forEach((trace) => {
      [trace.mesh, trace.linePlot, trace.scatterPlot].filter((part) => part && part.drawPick).forEach((part) => {
        part.drawPick = null;
        part.dirty = true; // so that it is drawn anew
      });
    });
  }

  const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done))));
  const drawn = Plotly.newPlot(view, traces, layout, options).then(() => {
    performance.mark("drawn");
    byId("poster")?.remove();
    return frame(); // nothing more is drawn until it is on the screen
  }).then(() => {
    view.on("plotly_afterplot", letPointerThrough);
    return !later.length ? letPointerThrough() : restyle({ visible: later.map(([layer]) => isShown(layer)) }, later.map(([, number]) => number));
  });

  document.querySelectorAll("input[data-layer]").forEach((box) => {
    box.addEventListener("change", () => restyle({ visible: box.checked }, layers[box.dataset.layer]));
  });

  // the contraction, step by step
  const slider = byId("step");
  let drawCurves = () => {};
  function showStep(step) {
    const changed = coordinates(data.steps.positions[step]);
    restyle({ x: [changed.x], y: [changed.y], z: [changed.z] }, layers.contracted);
    byId("step-text").textContent = data.steps.labels[step];
    slider.setAttribute("aria-valuetext", data.steps.labels[step]);
    drawCurves(data.steps.numbers[step]);
  }
  if (data.steps) {
    const curve = (name, values, color, dash) => ({ type: "scatter", mode: "lines+markers", name, x: data.steps.curve_x, y: values,
      line: { color, dash }, marker: { size: 4 }, hovertemplate: "%{y:.3g}" });
    const line = (step) => ({ type: "line", x0: step, x1: step, y0: 0, y1: 1, yref: "paper", line: { color: "#e8833a", width: 2 } });
    const grid = () => ({ gridcolor: theme().line, zeroline: false, color: theme().text });
    const curveLayout = () => ({
      template: "none", paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: theme().text, size: 11 },
      margin: { l: 46, r: 8, b: 32, t: 8 }, hovermode: "x", legend: { x: 0, y: 0, bgcolor: "rgba(0,0,0,0)" },
      xaxis: { title: { text: "step" }, ...grid() }, yaxis: { type: "log", exponentformat: "power", nticks: 6, ...grid() },
      shapes: [line(data.steps.numbers[Number(slider.value)])],
    });
    const shown = [curve("area, of the start", data.steps.areas, "#4c78a8", "solid")];
    if (data.steps.volumes) shown.push(curve("volume, of the start", data.steps.volumes, "#9a3fb5", "dot"));
    data.curves = () => Plotly.newPlot(byId("curves"), shown, curveLayout(), { displayModeBar: false, responsive: true });
    drawCurves = (step) => Plotly.relayout(byId("curves"), { shapes: [line(step)] });
    data.restyleCurves = () => Plotly.relayout(byId("curves"), curveLayout());
    slider.addEventListener("input", () => {
      const box = byId("show-contracted");
      if (!box.checked) { box.checked = true; restyle({ visible: true }, layers.contracted); }
      showStep(Number(slider.value));
    });
    let timer = null;
    const play = byId("play");
    play.addEventListener("click", () => {
      if (timer) { clearInterval(timer); timer = null; play.textContent = "Play"; return; }
      if (slider.value === slider.max) slider.value = "-1";
      play.textContent = "Stop";
      timer = setInterval(() => {
        slider.value = String(Number(slider.value) + 1);
        slider.dispatchEvent(new Event("input"));
        if (slider.value === slider.max) play.click();
      }, 450);
    });
  }

  // the row of a branch
  const choice = byId("branch");
  function select(branch) {
    if (choice) choice.value = String(branch);
    const path = branch < 0 ? [] : paths[branch];
    const line = coordinates(data.skeleton.nodes, path);
    restyle({ x: [line.x], y: [line.y], z: [line.z] }, [data.selectedTrace]);
    const rows = byId("branch-rows");
    rows.textContent = "";
    if (branch < 0 || !data.columns) return;
    data.columns.forEach((column) => {
      const row = rows.insertRow();
      const head = row.appendChild(document.createElement("th"));
      head.scope = "row";
      head.textContent = column.name;
      row.insertCell().textContent = column.values[branch];
    });
  }
  if (choice) {
    paths.forEach((_, branch) => choice.add(new Option(branch, branch)));
    choice.addEventListener("change", () => select(Number(choice.value)));
  }
  drawn.then(() => {
    let pointed = null; // the point under the mouse
    function choose(point) {
      const branch = (point.curveNumber === data.nodeTrace ? branchOfNode : branchOfPoint)[point.pointNumber];
      if (choice && branch !== Number(choice.value)) select(branch);
    }
    view.on("plotly_hover", (event) => { pointed = event.points[0]; });
    view.on("plotly_unhover", () => { pointed = null; });
    // plotly tells a click while it draws, when nothing may be changed, and again in each drawing until the button is up;
    // it tells of none if the button is up before
    view.on("plotly_click", (event) => setTimeout(() => choose(event.points[0])));
    let pressed = [0, 0];
    view.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; }, true);
    view.addEventListener("click", (event) => {
      const isDragged = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 3; // pixels
      if (pointed && !isDragged) choose(pointed);
    }, true);
    return data.curves && data.curves();
  }).then(() => { // what plotly draws has no names; the elements around it have
    document.querySelectorAll("#view > *, #curves > *, #js-plotly-tester").forEach((each) => each.setAttribute("aria-hidden", "true"));
    document.body.dataset.ready = "yes";
  });
  // the keys turn the camera by 10 degrees, to the right and upwards, and change its distance by a tenth
  const TURNS = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };
  const ZOOMS = { "+": 1 / 1.1, "=": 1 / 1.1, "-": 1.1 };
  const sum = (a, p, b, q) => ({ x: p * a.x + q * b.x, y: p * a.y + q * b.y, z: p * a.z + q * b.z });
  const turned = (a, b, degrees) => sum(a, Math.cos(degrees * Math.PI / 180), b, Math.sin(degrees * Math.PI / 180));
  view.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(TURNS[event.key] || ZOOMS[event.key])) return;
    event.preventDefault();
    const [right, above] = TURNS[event.key] || [0, 0];
    const { eye, up, ...others } = view._fullLayout.scene._scene.getCamera();
    const far = Math.hypot(eye.x, eye.y, eye.z), front = sum(eye, 1 / far, eye, 0);
    const side = { x: up.y * front.z - up.z * front.y, y: up.z * front.x - up.x * front.z, z: up.x * front.y - up.y * front.x };
    const level = turned(front, side, right);
    Plotly.relayout(view, { "scene.camera": { ...others, up: turned(up, level, -above),
      eye: sum(turned(level, up, above), far * (ZOOMS[event.key] || 1), eye, 0) } });
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    Plotly.relayout(view, { "font.color": theme().text });
    if (data.restyleCurves) data.restyleCurves();
  });
})();
