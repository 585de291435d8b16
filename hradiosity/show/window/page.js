// Draws DATA with WebGL; see page.py for what is in it.

const MODES = [["flat", "Flat"], ["smooth", "Smooth"], ["wireframe", "Wireframe"], ["unshaded", "Unshaded"],
  ["false-color", "False colours"]];
const state = { mode: DATA.mode, quantity: "illuminance", log: false, lines: DATA.lines, marks: !DATA.solved, walk: false,
  pose: structuredClone(DATA.pose), picked: null };
const by = (id) => document.getElementById(id);
const canvas = by("view");
const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });

async function unpack(text, type) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new type(await new Response(stream).arrayBuffer());
}

// Where one looks from: the same angles as in the window.

function axes(pose) {
  const [cy, sy, cp, sp] = [Math.cos(pose.yaw), Math.sin(pose.yaw), Math.cos(pose.pitch), Math.sin(pose.pitch)];
  return { forward: [cp * cy, cp * sy, sp], right: [sy, -cy, 0], up: [-sp * cy, -sp * sy, cp] };
}
const plus = (a, b, k) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const minus = (a, b) => plus(a, b, -1);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function turn(yaw, pitch) {
  state.pose.yaw += yaw;
  state.pose.pitch = Math.min(Math.max(state.pose.pitch + pitch, -1.569), 1.569);
}
function orbit(yaw, pitch) {
  const focus = plus(state.pose.position, axes(state.pose).forward, state.pose.distance);
  turn(yaw, pitch);
  state.pose.position = plus(focus, axes(state.pose).forward, -state.pose.distance);
}
function nearer(factor) {
  const { forward } = axes(state.pose), focus = plus(state.pose.position, forward, state.pose.distance);
  state.pose.distance = Math.max(state.pose.distance * factor, 1e-3 * DATA.size);
  state.pose.position = plus(focus, forward, -state.pose.distance);
}
function walk(ahead, aside, rise) {
  const step = 0.02 * DATA.size, level = [Math.cos(state.pose.yaw), Math.sin(state.pose.yaw), 0];
  const at = plus(state.pose.position, level, step * ahead);
  state.pose.position = plus(plus(at, axes(state.pose).right, step * aside), [0, 0, 1], step * rise);
}
function matrix() {
  const { forward, right, up } = axes(state.pose), p = state.pose.position;
  const t = 1 / Math.tan(state.pose.angle / 2), a = canvas.width / canvas.height;
  const near = 2e-4 * DATA.size, far = 20 * DATA.size;
  const rows = [right.map((v) => v * t / a), up.map((v) => v * t), forward.map((v) => v * (far + near) / (far - near)),
    forward];
  const last = [0, 0, -2 * far * near / (far - near), 0].map((v, k) => v - dot(rows[k], p));
  return new Float32Array([0, 1, 2].flatMap((c) => rows.map((row) => row[c])).concat(last));
}

// WebGL

const VERTEX = `attribute vec3 place; attribute vec3 colour; attribute vec3 normal; uniform mat4 look; uniform vec3 eye;
uniform float lift; varying vec3 shown;
void main() {
  shown = colour;
  gl_Position = look * vec4(place, 1.0);
  gl_Position.z -= lift * gl_Position.w;
  gl_PointSize = 6.0;
  if (dot(normal, eye - place) < 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;
const FRAGMENT = `precision mediump float; varying vec3 shown; void main() { gl_FragColor = vec4(shown, 1.0); }`;

function makeProgram() {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  return program;
}
function buffer(values, kind = gl.ARRAY_BUFFER) {
  const made = gl.createBuffer();
  gl.bindBuffer(kind, made);
  gl.bufferData(kind, values, gl.STATIC_DRAW);
  return made;
}

const A = {};
let program, surface, outline, sensors, arrows, lamps, colourBuffer;

async function load() {
  const wanted = { position: Float32Array, triangle: Uint8Array, outline: Uint8Array, material: Int32Array,
    object: Int32Array, element: Int32Array, level: Int32Array, area: Float32Array, map: Uint8Array };
  for (const [name, type] of Object.entries(wanted)) A[name] = await unpack(DATA[name], type);
  A.colours = {};
  for (const [name, text] of Object.entries(DATA.colours)) A.colours[name] = await unpack(text, Uint8Array);
  A.values = {};
  for (const [name, text] of Object.entries(DATA.values || {})) A.values[name] = await unpack(text, Float32Array);
  A.elements = {};
  for (const [name, text] of Object.entries(DATA.elements || {}))
    A.elements[name] = await unpack(text, name === "spectra" ? Uint16Array : Float32Array);
  A.sensors = {};
  for (const [name, text] of Object.entries(DATA.sensors))
    if (name !== "names") A.sensors[name] = await unpack(text, name === "spectra" ? Uint16Array : Float32Array);
  A.lamps = await unpack(DATA.lamps, Float32Array);
}

function prepare() {
  program = makeProgram();
  gl.getExtension("OES_element_index_uint");
  const n = DATA.count, faces = [], edges = [], normal = new Float32Array(12 * n);
  for (let c = 0; c < n; c++) {
    const k = 4 * c, p = (i) => Array.from(A.position.subarray(3 * (k + i), 3 * (k + i) + 3));
    faces.push(k, k + 1, k + 2);
    if (!A.triangle[c]) faces.push(k, k + 2, k + 3);
    const across = cross(minus(p(2), p(0)), minus(p(3), p(1)));
    for (let i = 0; i < 4; i++) normal.set(across, 3 * (k + i));
    const count = A.triangle[c] ? 3 : 4;
    for (let i = 0; i < count; i++) if (A.outline[k + i]) edges.push(k + i, k + (i + 1) % count);
  }
  A.normal = normal;
  surface = { place: buffer(A.position), normal: buffer(normal), index: index(faces), count: faces.length };
  outline = { index: index(edges), count: edges.length };
  sensors = points(A.sensors.marks), arrows = points(A.sensors.lines), lamps = points(A.lamps);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.CULL_FACE);
}
const index = (list) => buffer(new Uint32Array(list), gl.ELEMENT_ARRAY_BUFFER);
const points = (values) => ({ place: buffer(values), count: values.length / 3 });

// Colours of the mode, at all corners.

const toLinear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const toScreen = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

function scale() {
  return DATA.scales[`${state.quantity} ${state.log ? "log" : "linear"}`];
}
function share(value) {
  const { low, high, log } = scale();
  const s = log ? Math.log(Math.max(value, low) / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.min(Math.max(s, 0), 1);
}
function paint() {
  const n = DATA.count, out = new Uint8Array(12 * n);
  if (state.mode === "false-color" && DATA.solved) {
    const values = A.values[state.quantity];
    for (let k = 0; k < 4 * n; k++) {
      const at = 3 * Math.round(share(values[k]) * 255);
      out.set(A.map.subarray(at, at + 3), 3 * k);
    }
  } else {
    const name = state.mode === "wireframe" ? "smooth" : state.mode === "false-color" ? "flat" : state.mode;
    const given = A.colours[name];
    for (let k = 0; k < 4 * n; k++) {
      const at = given.length === 12 * n ? 3 * k : 3 * (k >> 2);
      out.set(given.subarray(at, at + 3), 3 * k);
    }
    if (state.mode === "wireframe") {
      const dimmed = Uint8Array.from({ length: 256 }, (_, v) => Math.round(255 * toScreen(0.5 * toLinear(v / 255))));
      for (let k = 0; k < out.length; k++) out[k] = dimmed[out[k]];
    }
  }
  colourBuffer = buffer(out);
  legend();
  status();
}

function attribute(name, made, size, type = gl.FLOAT, normalised = false, fallback = null) {
  const at = gl.getAttribLocation(program, name);
  if (made) {
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.enableVertexAttribArray(at);
    gl.vertexAttribPointer(at, size, type, normalised, 0, 0);
  } else {
    gl.disableVertexAttribArray(at);
    gl.vertexAttrib3f(at, ...fallback);
  }
}
function draw() {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(0.13, 0.14, 0.16, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.uniformMatrix4fv(gl.getUniformLocation(program, "look"), false, matrix());
  gl.uniform3fv(gl.getUniformLocation(program, "eye"), state.pose.position);
  const lift = gl.getUniformLocation(program, "lift");
  gl.uniform1f(lift, 0);
  attribute("place", surface.place, 3);
  attribute("normal", surface.normal, 3);
  attribute("colour", colourBuffer, 3, gl.UNSIGNED_BYTE, true);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, surface.index);
  gl.drawElements(gl.TRIANGLES, surface.count, gl.UNSIGNED_INT, 0);
  gl.uniform1f(lift, 1e-5);
  if (state.lines || state.mode === "wireframe") {
    attribute("colour", null, 3, 0, false, [0.85, 0.85, 0.85]);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, outline.index);
    gl.drawElements(gl.LINES, outline.count, gl.UNSIGNED_INT, 0);
  }
  attribute("normal", null, 3, 0, false, [0, 0, 0]);
  if (state.marks) {
    for (const [part, kind, ink] of [[sensors, gl.POINTS, [0.337, 0.706, 0.914]], [arrows, gl.LINES,
      [0.337, 0.706, 0.914]], [lamps, gl.LINES, [0.902, 0.624, 0]]]) {
      if (!part.count) continue;
      attribute("place", part.place, 3);
      attribute("colour", null, 3, 0, false, ink);
      gl.drawArrays(kind, 0, part.count);
    }
  }
  if (state.picked) {
    attribute("place", state.picked.lines, 3);
    attribute("colour", null, 3, 0, false, [1, 0.92, 0.2]);
    gl.drawArrays(gl.LINES, 0, state.picked.count);
  }
}

// Picking: the nearest cell that faces the ray (Möller & Trumbore 1997), or a sensor close to the mouse.

function pick(x, y) {
  const { forward, right, up } = axes(state.pose), origin = state.pose.position;
  const half = Math.tan(state.pose.angle / 2), w = canvas.clientWidth, h = canvas.clientHeight;
  const direction = plus(plus(forward, right, half * w / h * (2 * x / w - 1)), up, half * (1 - 2 * y / h));
  let best = Infinity, found = -1;
  for (let c = 0; c < DATA.count; c++) {
    const p = (i) => A.position.subarray(12 * c + 3 * i, 12 * c + 3 * i + 3);
    const first = p(0), u = minus(p(1), first), v = minus(p(A.triangle[c] ? 2 : 3), first), n = cross(u, v);
    const slope = dot(n, direction);
    if (slope >= 0) continue;
    const offset = minus(first, origin), along = dot(offset, n) / slope;
    if (along <= 0 || along >= best) continue;
    const turned = cross(offset, direction), s = dot(v, turned) / slope, t = -dot(u, turned) / slope;
    if (s < 0 || t < 0 || (A.triangle[c] ? s + t > 1 : s > 1 || t > 1)) continue;
    best = along, found = c;
  }
  let sensor = -1, miss = 9;
  for (let k = 0; state.marks && k < sensors.count; k++) {
    const to = minus(A.sensors.marks.subarray(3 * k, 3 * k + 3), origin), depth = dot(to, forward);
    if (depth <= 0 || depth > best * 1.001) continue;
    const px = w / 2 * (1 + dot(to, right) / (depth * half * w / h)), py = h / 2 * (1 - dot(to, up) / (depth * half));
    const off = Math.hypot(px - x, py - y);
    if (off < miss) miss = off, sensor = k;
  }
  if (sensor >= 0) showSensor(sensor);
  else if (found >= 0) showCell(found);
  else clearPick();
}
function clearPick() {
  state.picked = null;
  by("facts").style.display = "none";
}
const fixed = (v, n) => v.toFixed(n);
const precise = (v) => Number(v.toPrecision(4)).toString();

function spectrum(from, k) {
  if (!from.spectra) return null;
  const n = DATA.bands.lower.length;
  return Array.from(from.spectra.subarray(n * k, n * k + n), (v) => v / 65535 * from.top[k]);
}
function showCell(c) {
  const e = A.element[c], lines = [];
  for (let d = 0; d < DATA.count; d++) {
    if (A.element[d] !== e) continue;
    const count = A.triangle[d] ? 3 : 4;
    for (let i = 0; i < count; i++) {
      if (!A.outline[4 * d + i]) continue;
      for (const k of [i, (i + 1) % count]) lines.push(...A.position.subarray(12 * d + 3 * k, 12 * d + 3 * k + 3));
    }
  }
  state.picked = { lines: buffer(new Float32Array(lines)), count: lines.length / 3 };
  const facts = [["object", DATA.objects[A.object[c]]], ["material", DATA.materials[A.material[c]]],
    ["area", `${precise(A.area[e])} m²`]];
  if (DATA.solved) {
    const E = A.elements;
    facts.push(["level", A.level[c]], ["illuminance", `${precise(A.values["cell illuminance"][c])} lx`],
      ["x, y", `${fixed(E.xy[2 * e], 4)}, ${fixed(E.xy[2 * e + 1], 4)}`],
      ["CCT", E.cct[e] ? `${fixed(E.cct[e], 0)} K` : "none"],
      ["luminance", `${precise(A.values["cell luminance"][c])} cd/m²`]);
  }
  showFacts(DATA.solved ? `element ${e}` : `patch ${e}`, facts, spectrum(A.elements, e), null);
}
function showSensor(k) {
  const S = A.sensors, r = 0.012 * DATA.size, lines = [];
  const [at, place] = [S.marks, S.position].map((list) => Array.from(list.subarray(3 * k, 3 * k + 3)));
  for (let i = 0; i < 3; i++) for (const sign of [-r, r]) lines.push(...at.map((v, j) => (i === j ? v + sign : v)));
  state.picked = { lines: buffer(new Float32Array(lines)), count: 6 };
  const facts = [["point", `${place.map((v) => fixed(v, 3)).join(", ")} m`]];
  const looks = S.looks[k] > 0, told = looks ? "luminance" : "lux";
  if (S[told]) facts.push([looks ? "luminance" : "illuminance",
    `${fixed(S[told][k], 1)} ± ${fixed(S[`${told} half`][k], 1)} ${looks ? "cd/m²" : "lx"}`],
    ["x, y", `${fixed(S.x[k], 4)}, ${fixed(S.y[k], 4)}`],
    ["CCT", S.cct[k] ? `${fixed(S.cct[k], 0)} ± ${fixed(S["cct half"][k], 0)} K` : "none"]);
  const n = DATA.bands.lower.length;
  const half = S.half && !looks ? Array.from(S.half.subarray(n * k, n * k + n)) : null;
  showFacts(DATA.sensors.names[k], facts, spectrum(S, k), half, looks);
}
function showFacts(title, facts, values, half, looks = false) {
  const box = by("facts");
  box.replaceChildren();
  box.appendChild(document.createElement("h1")).textContent = title;
  const table = box.appendChild(document.createElement("table"));
  for (const fact of facts) {
    const row = table.insertRow();
    for (const text of fact) row.insertCell().textContent = text;
  }
  if (values) chart(box.appendChild(document.createElement("canvas")), values, half, looks);
  box.style.display = "block";
}
function roundUp(value) {
  const decade = 10 ** Math.floor(Math.log10(value));
  return decade * [1, 1.2, 1.6, 2, 2.4, 3.2, 4, 6, 8, 10].find((m) => decade * m >= value * (1 - 1e-9));
}
function chart(sheet, values, half, looks) {
  sheet.width = 380, sheet.height = 180;
  const g = sheet.getContext("2d"), { lower, upper } = DATA.bands, [left, top, w, h] = [56, 22, 316, 124];
  const high = roundUp(Math.max(...values.map((v, k) => v + (half ? half[k] : 0)), 1e-30));
  const first = lower[0], last = upper[upper.length - 1];
  const X = (v) => left + w * (v - first) / (last - first), Y = (v) => top + h * (1 - Math.max(v, 0) / high);
  g.fillStyle = "#26292f", g.fillRect(left, top, w, h);
  g.font = "11px sans-serif", g.fillStyle = "#f0f0f0";
  const name = looks ? "radiance [W m⁻² sr⁻¹ nm⁻¹]" : "irradiance [W m⁻² nm⁻¹]";
  g.fillText(half ? `${name} ± 95 % interval` : name, 4, 12);
  g.fillStyle = "#a5a8af", g.textAlign = "right";
  for (let k = 0; k <= 4; k++) g.fillText(Number((high * k / 4).toPrecision(3)).toString(), left - 5, Y(high * k / 4) + 4);
  g.textAlign = "center";
  for (let v = Math.ceil(first / 50) * 50; v <= last; v += 50) g.fillText(v, X(v), top + h + 14);
  g.fillText("wavelength [nm]", left + w / 2, top + h + 29);
  const path = (list) => values.forEach((_, k) => {
    g.lineTo(X(lower[k]), Y(list(k)));
    g.lineTo(X(upper[k]), Y(list(k)));
  });
  if (half) {
    g.beginPath();
    path((k) => values[k] + half[k]);
    for (let k = values.length - 1; k >= 0; k--) {
      g.lineTo(X(upper[k]), Y(values[k] - half[k]));
      g.lineTo(X(lower[k]), Y(values[k] - half[k]));
    }
    g.fillStyle = "rgba(222, 200, 90, 0.4)", g.fill();
  }
  g.beginPath();
  path((k) => values[k]);
  g.strokeStyle = "#f5e182", g.lineWidth = 1.5, g.stroke();
}

// Legend, buttons, keys, mouse

function legend() {
  const box = by("legend"), shown = state.mode === "false-color" && DATA.solved;
  box.style.display = shown ? "block" : "none";
  if (!shown) return;
  const ticks = scale().ticks.map((v) => Number(v.toPrecision(6)).toString());
  box.width = 110, box.height = 330;
  const g = box.getContext("2d");
  g.fillStyle = "#f0f0f0", g.font = "13px sans-serif";
  g.fillText(state.quantity, 2, 14);
  g.fillText(`[${scale().unit}]`, 2, 31);
  for (let y = 0; y < 280; y++) {
    const at = 3 * Math.round((1 - y / 279) * 255);
    g.fillStyle = `rgb(${A.map.subarray(at, at + 3).join(",")})`;
    g.fillRect(2, 42 + y, 20, 1);
  }
  g.fillStyle = "#f0f0f0", g.textBaseline = "middle";
  scale().ticks.forEach((v, k) => {
    const y = 42 + 279 * (1 - share(v));
    g.fillRect(22, y, 5, 1);
    g.fillText(ticks[k], 31, y);
  });
}
function status() {
  const mode = state.mode === "unshaded" ? "paints under D65, white is reflectance 1" : DATA.exposure;
  by("status").textContent = [DATA.title, state.mode, state.mode === "false-color" ? "" : mode,
    state.walk ? "on foot" : "orbit", "h: help"].filter(Boolean).join("  ·  ");
}
const switches = {
  i: ["lx | cd/m²", () => { state.quantity = state.quantity === "illuminance" ? "luminance" : "illuminance"; },
    () => state.quantity === "luminance"],
  k: ["Log", () => { state.log = !state.log; }, () => state.log],
  l: ["Lines", () => { state.lines = !state.lines; }, () => state.lines],
  m: ["Marks", () => { state.marks = !state.marks; }, () => state.marks],
  f: ["Walk", () => { state.walk = !state.walk; }, () => state.walk],
  c: ["Start", () => { state.pose = structuredClone(DATA.pose); }, () => false],
  r: ["All", () => { state.pose = structuredClone(DATA.overview); state.walk = false; }, () => false],
  h: ["Help", () => toggleHelp(), () => by("help").style.display === "block"],
};
function toggleHelp() {
  by("help").style.display = by("help").style.display === "block" ? "none" : "block";
}
function act(key) {
  if (key in switches) switches[key][1]();
  else if ("12345".includes(key)) state.mode = MODES[key - 1][0];
  else return false;
  buttons();
  paint();
  draw();
  return true;
}
function buttons() {
  const bar = by("bar");
  bar.replaceChildren();
  const add = (label, key, on) => {
    const button = bar.appendChild(document.createElement("button"));
    button.textContent = label, button.className = on ? "on" : "", button.title = `key ${key}`;
    button.onclick = () => act(key);
  };
  MODES.forEach(([mode, label], k) => add(label, String(k + 1), state.mode === mode));
  for (const [key, [label, , on]] of Object.entries(switches)) add(label, key, on());
}
const STEPS = { w: [1, 0, 0], s: [-1, 0, 0], d: [0, 1, 0], a: [0, -1, 0], e: [0, 0, 1], q: [0, 0, -1],
  ArrowUp: [1, 0, 0], ArrowDown: [-1, 0, 0], ArrowRight: [0, 1, 0], ArrowLeft: [0, -1, 0] };

function listen() {
  let from = null, moved = 0;
  canvas.onpointerdown = (e) => { from = [e.clientX, e.clientY]; moved = 0; canvas.setPointerCapture(e.pointerId); };
  canvas.onpointermove = (e) => {
    if (!from) return;
    const dx = e.clientX - from[0], dy = e.clientY - from[1], h = canvas.clientHeight;
    moved += Math.abs(dx) + Math.abs(dy);
    if (moved <= 4) return;
    from = [e.clientX, e.clientY];
    if (e.shiftKey || e.buttons === 4) {
      const metres = 2 * state.pose.distance * Math.tan(state.pose.angle / 2) / h, { right, up } = axes(state.pose);
      state.pose.position = plus(plus(state.pose.position, right, -metres * dx), up, metres * dy);
    } else if (state.walk) turn(dx * state.pose.angle / h, dy * state.pose.angle / h);
    else orbit(-Math.PI * dx / h, -Math.PI * dy / h);
    draw();
  };
  canvas.onpointerup = (e) => {
    if (from && moved <= 4) { pick(e.clientX, e.clientY); draw(); }
    from = null;
  };
  canvas.onwheel = (e) => {
    e.preventDefault();
    if (state.walk) walk(e.deltaY < 0 ? 2 : -2, 0, 0);
    else nearer(e.deltaY < 0 ? 1 / 1.15 : 1.15);
    draw();
  };
  window.onkeydown = (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    const step = STEPS[e.key];
    if (step && state.walk) walk(...step);
    else if (step) { orbit(0.07 * step[1], -0.07 * step[0]); if (step[2]) nearer(step[2] > 0 ? 1 / 1.15 : 1.15); }
    else if (e.key === "Escape") { by("help").style.display = "none"; clearPick(); buttons(); }
    else if (act(e.key)) return;
    draw();
  };
  window.onresize = draw;
}

if (!gl) by("status").textContent = "this browser has no WebGL";
else load().then(() => {
  document.title = DATA.title;
  prepare();
  buttons();
  paint();
  draw();
  listen();
  document.body.dataset.ready = "1";
});
