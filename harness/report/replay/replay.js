// Plays recorded joint positions: no library, no request. The data lies beside it as JSON; harness/report/replay says how.
(() => {
"use strict";
const root = document.getElementById("replay-player");
const data = JSON.parse(root.querySelector("script").textContent);
const part = (name) => root.querySelector(`[data-part="${name}"]`);
const views = root.querySelectorAll(".replay-views figure");
const COLOURS = data.colours, GREEN = "#00805c", INK = "#2b3036";
const HOME = { turn: -0.9, rise: 0.35, zoom: 1 };
const LIGHT = [-0.35, -0.5, 0.8];

// --- numbers -------------------------------------------------------------------------------------------------------

function array(text, Type) {
  return new Type(Uint8Array.from(atob(text), (char) => char.charCodeAt(0)).buffer);
}

// Frames are 12 numbers, three rows of four: a rotation and a translation.
function times(a, b) {
  const out = new Array(12);
  for (let row = 0; row < 12; row += 4) {
    for (let column = 0; column < 4; column++) {
      out[row + column] = a[row] * b[column] + a[row + 1] * b[4 + column] + a[row + 2] * b[8 + column]
        + (column === 3 ? a[row + 3] : 0);
    }
  }
  return out;
}

function motion(joint, position) {
  const [x, y, z] = joint.axis;
  if (joint.slides) return [1, 0, 0, x * position, 0, 1, 0, y * position, 0, 0, 1, z * position];
  const s = Math.sin(position), c = Math.cos(position), d = 1 - c;  // Rodrigues' formula
  return [c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0,
    y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0,
    z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0];
}

// The frame of each joint's child link in the world, and that of the end effector last.
function place(scene, positions) {
  const frames = [];
  let frame = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  scene.joints.forEach((joint, index) => {
    frame = times(times(frame, joint.frame), motion(joint, positions[index]));
    frames.push(frame);
  });
  frames.push(times(frame, scene.tip));
  return frames;
}

const origin = (frame) => [frame[3], frame[7], frame[11]];
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// --- what is shown ---------------------------------------------------------------------------------------------------

function unpack(episode, scene) {
  const columns = episode.scales.length, whole = array(episode.values, Int16Array), frames = whole.length / columns;
  const rows = Array.from({ length: frames }, (_, row) => episode.scales.map((scale, column) => whole[row * columns + column] * scale));
  const dof = scene.joints.length;
  const path = rows.map((row) => origin(place(scene, row).at(-1)));
  return {
    rows, path, dof, outcome: episode.outcome, last: episode.last, targets: episode.targets,
    obstacles: episode.obstacles ?? [],
    distance: rows.map((row) => row[dof]), paid: rows.map((row) => row[dof + 1]),
    stepOf: (frame) => (frames > 1 ? frame * episode.last / (frames - 1) : 0),
  };
}

// Between two frames joint positions are interpolated.
function rowAt(episode, step) {
  const frame = episode.last ? clamp(step / episode.last, 0, 1) * (episode.rows.length - 1) : 0;
  const before = Math.floor(frame), after = Math.min(before + 1, episode.rows.length - 1), share = frame - before;
  const row = episode.rows[before].map((value, column) => value + share * (episode.rows[after][column] - value));
  const target = episode.targets.findLast((one) => one[0] <= before) ?? episode.targets[0];
  return { row, frame, target: target.slice(1) };
}

const state = { show: null, episode: 0, step: 0, playing: false, view: { ...HOME, centre: [0, 0, 0], radius: 1 }, sides: [], last: 0 };

function choose(show, episode) {
  if (state.show !== show) {
    const shown = data.shows[show].sides[0], last = Math.max(...shown.episodes.map((one) => one.last));
    part("speed").value = last * shown.period > 3 ? 1 : 0.25;  // what takes a moment is shown slowly
  }
  state.show = show;
  state.episode = episode;
  const shown = data.shows[show];
  state.sides = sidesOf(show, episode);
  state.last = lastOf(state.sides);
  Object.assign(state.view, framed(state.sides));
  part("comparison").value = show;
  part("episode").replaceChildren(...shown.numbers.map((_, index) => new Option(named(shown, index), index)));
  part("episode").value = episode;
  part("episode").parentElement.hidden = Boolean(shown.told) && shown.numbers.length < 2;
  const evaluated = `Episode ${shown.numbers[episode]} of the final evaluation, seed ${seedsOf(shown, episode).join(" | ")}`;
  part("told").textContent = `${shown.told ?? evaluated}: ${endings(shown, episode)}.${shared(shown, episode)}`;
  mark(show, episode);
  part("scrub").max = state.last;
  views.forEach((figure, index) => {
    const side = state.sides[index];
    figure.hidden = !side;
    if (!side) return;
    figure.querySelector("h3").textContent = side.title;
    figure.querySelector("h3").style.borderColor = COLOURS[index];
    const badge = figure.querySelector("b");
    badge.textContent = side.now.outcome;
    badge.className = side.now.outcome;
    figure.querySelector("canvas").setAttribute("aria-label", `${side.title}: the arm in episode ${shown.numbers[episode]}, which ended: ${side.now.outcome}`);
  });
  const { error, unit } = state.sides[0];
  part("error").textContent = error === "distance" ? "Distance to the target" : error[0].toUpperCase() + error.slice(1);
  part("unit").textContent = unit;
  plot(part("distance"), "distance");
  plot(part("paid"), "paid");
  seek(0);
}

// What each side of a show did in an episode.
function sidesOf(show, episode) {
  return data.shows[show].sides.map((side) => {
    const scene = data.scenes[side.scene];
    return { ...side, place: side.scene, scene, now: unpack(side.episodes[episode], scene) };
  });
}

const lastOf = (sides) => Math.max(...sides.map((side) => side.now.last));

// How an episode ended on every side, said once where it is the same.
function endings(shown, index) {
  return [...new Set(shown.sides.map((side) => side.episodes[index].outcome))].join(" | ");
}

const seedsOf = (shown, index) => [...new Set(shown.sides.map((side) => side.seeds[index]))];

function named(shown, index) {
  const seed = shown.pairs ? `seed ${seedsOf(shown, index)}, ` : "";
  return `${seed}${shown.numbers[index]}: ${endings(shown, index)}`;
}

// How often a pair of episodes ends as this one.
function shared(shown, index) {
  if (!shown.pairs) return "";
  const ended = shown.pairs.seeds.find(([seed]) => seed === shown.sides[0].seeds[index])[1][shown.numbers[index] - 1];
  return ` ${capital(shown.pairs.kinds.find((one) => one.kind === Number(ended)).share)}.`;
}

const capital = (text) => text[0].toUpperCase() + text.slice(1);

// --- all pairs, a cell for each ------------------------------------------------------------------------------------------

const grids = data.shows.map((shown, show) => shown.pairs && fill(shown, show));

// The cells of a show by what they play; the arrows go from one to the next, Tab leaves them.
function fill(shown, show) {
  const grid = root.querySelector(`[data-pairs="${show}"] [data-part="grid"]`), cells = [], byIndex = [];
  const index = new Map(shown.numbers.map((number, at) => [`${shown.sides[0].seeds[at]} ${number}`, at]));
  const told = new Map(shown.pairs.kinds.map((one) => [String(one.kind), one.told]));
  grid.setAttribute("role", "grid");
  grid.setAttribute("aria-label", "All pairs of episodes; a row for each seed");
  grid.append(...shown.pairs.seeds.map(([seed, ended]) => {
    const row = document.createElement("div"), head = document.createElement("span");
    row.setAttribute("role", "row");
    head.setAttribute("role", "rowheader");
    head.textContent = `seed ${seed}`;
    row.append(head, ...[...ended].map((kind, at) => {
      const cell = document.createElement("button"), plays = index.get(`${seed} ${at + 1}`);
      const words = `Seed ${seed}, episode ${at + 1}: ${told.get(kind)}`;
      Object.assign(cell, { type: "button", className: `pair kind-${kind}`, tabIndex: -1, title: plays === undefined ? `${words}; not among those to be played` : words });
      cell.setAttribute("role", "gridcell");
      cell.setAttribute("aria-label", cell.title);
      if (plays === undefined) cell.setAttribute("aria-disabled", "true");
      else {
        byIndex[plays] = cell;
        cell.addEventListener("click", () => choose(show, plays));
      }
      cells.push(cell);
      return cell;
    }));
    return row;
  }));
  const note = document.createElement("p");
  note.textContent = `A cell is a pair with the same start and target; its left half is filled where the baseline reaches, its right half where the other does. ${shown.numbers.length} of ${cells.length} can be played: click one.`;
  grid.after(note);
  grid.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -shown.pairs.seeds[0][1].length, ArrowDown: shown.pairs.seeds[0][1].length }[event.key];
    const next = cells[cells.indexOf(document.activeElement) + by];
    if (!next) return;
    event.preventDefault();
    document.activeElement.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  });
  return byIndex;
}

function mark(show, episode) {
  root.querySelectorAll("[data-pairs]").forEach((one) => { one.hidden = Number(one.dataset.pairs) !== show; });
  grids[show]?.forEach((cell, index) => {
    cell.setAttribute("aria-selected", String(index === episode));
    cell.tabIndex = index === episode ? 0 : -1;
  });
}

// The camera looks at the middle of the arm's foot and of all paths and targets.
function framed(sides) {
  const low = [0, 0, 0], high = [0, 0, 0];
  for (const side of sides) {
    const joints = place(side.scene, side.now.rows[0]).map(origin);
    for (const point of [...side.now.path, ...side.now.targets.map((one) => one.slice(1)), ...joints]) {
      point.forEach((value, axis) => {
        low[axis] = Math.min(low[axis], value);
        high[axis] = Math.max(high[axis], value);
      });
    }
  }
  const centre = low.map((value, axis) => (value + high[axis]) / 2);
  return { centre, radius: Math.max(Math.hypot(...low.map((value, axis) => high[axis] - value)) / 2, 1e-3) };
}

// --- the camera ------------------------------------------------------------------------------------------------------

// Column-major 4 x 4: the projection times the view.
function camera(view, width, height) {
  const { turn, rise, zoom, centre, radius } = view, far = radius * 3.3 / zoom;
  const back = [Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise)];
  const right = [-Math.sin(turn), Math.cos(turn), 0];
  const up = [-Math.sin(rise) * Math.cos(turn), -Math.sin(rise) * Math.sin(turn), Math.cos(rise)];
  const eye = centre.map((value, axis) => value + far * back[axis]);
  const focal = 2.6 * Math.min(1, width / height), near = far * 0.05, end = far * 4;
  const rows = [[right, focal * height / width], [up, focal]].map(([axis, scale]) => [...axis, -dot(axis, eye)].map((value) => value * scale));
  const depth = [...back, -dot(back, eye)];
  const a = (end + near) / (near - end), b = 2 * end * near / (near - end);
  rows.push(depth.map((value, index) => a * value + (index === 3 ? b : 0)), depth.map((value) => -value));
  return [0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column]));
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

// To pixels of the canvas; null behind the camera.
function project(matrix, point, width, height) {
  const [x, y, , w] = [0, 1, 2, 3].map((row) => matrix[row] * point[0] + matrix[4 + row] * point[1] + matrix[8 + row] * point[2] + matrix[12 + row]);
  return w > 0 ? [(x / w + 1) / 2 * width, (1 - y / w) / 2 * height] : null;
}

// --- surfaces, by WebGL ----------------------------------------------------------------------------------------------

const VERTEX = `#version 300 es
in vec3 point; in vec3 normal;
uniform mat4 camera, frame; uniform vec3 light; uniform float shadow;
out vec3 facing;
void main() {
  vec4 world = frame * vec4(point, 1.0);
  if (shadow > 0.0) world = vec4(world.xy - light.xy / light.z * world.z, 0.0, 1.0);
  facing = mat3(frame) * normal;
  gl_Position = camera * world;
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing; uniform vec3 light; uniform vec4 colour; uniform float shadow; out vec4 pixel;
void main() {
  vec3 n = normalize(facing);
  float bright = 0.42 + 0.5 * max(dot(n, normalize(light)), 0.0) + 0.13 * n.z + 0.1 * max(dot(n, vec3(0.8, 0.5, 0.0)), 0.0);
  pixel = shadow > 0.0 ? vec4(0.0, 0.0, 0.0, colour.a) : vec4(colour.rgb * bright, 1.0);
}`;

const stage = document.createElement("canvas");
const gl = stage.getContext("webgl2", { antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: true });
const drawer = gl && prepare();
part("flat").hidden = Boolean(gl);

function prepare() {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.bindAttribLocation(program, 0, "point");
  gl.bindAttribLocation(program, 1, "normal");
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  const uniform = Object.fromEntries(["camera", "frame", "light", "colour", "shadow"].map((name) => [name, gl.getUniformLocation(program, name)]));
  gl.uniform3fv(uniform.light, LIGHT);
  return { uniform, ball: upload(...ball()), cube: upload(...cube()), scenes: data.scenes.map((scene) => scene.bodies.map(load)) };
}

function load(body) {
  const whole = array(body.points, Int16Array), points = Float32Array.from(whole, (value) => value * body.scale);
  const colour = [1, 3, 5].map((at) => parseInt(body.colour.slice(at, at + 2), 16) / 255);
  return { ...upload(points, array(body.faces, Uint16Array)), joint: body.joint, colour: [...colour, 1] };
}

function ball() {
  const points = [], faces = [], around = 16, rings = 10;
  for (let ring = 0; ring <= rings; ring++) {
    for (let at = 0; at <= around; at++) {
      const tilt = Math.PI * ring / rings, turn = 2 * Math.PI * at / around, here = ring * (around + 1) + at;
      points.push(Math.sin(tilt) * Math.cos(turn), Math.sin(tilt) * Math.sin(turn), Math.cos(tilt));
      if (ring < rings && at < around) faces.push(here, here + around + 1, here + 1, here + 1, here + around + 1, here + around + 2);
    }
  }
  return [Float32Array.from(points), Uint16Array.from(faces)];
}

function cube() {
  const points = [], faces = [];
  for (let corner = 0; corner < 8; corner++) points.push(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
  for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) faces.push(a, b, c, a, c, d);
  return [Float32Array.from(points), Uint16Array.from(faces)];
}

// Corners of triangles with normals: round where neighbours meet at less than 40 degrees, else sharp.
function upload(points, faces) {
  const normals = [], around = new Map(), corners = new Float32Array(faces.length * 6);
  const at = (corner) => points.subarray(3 * corner, 3 * corner + 3);
  const key = (corner) => Array.from(at(corner), (value) => Math.round(value * 1e5)).join();
  for (let face = 0; face < faces.length; face += 3) {
    const [a, b, c] = [0, 1, 2].map((index) => at(faces[face + index]));
    const u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]], v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    normals.push(normal);
    for (let index = 0; index < 3; index++) {
      const name = key(faces[face + index]);
      if (!around.has(name)) around.set(name, []);
      around.get(name).push(normal);
    }
  }
  for (let corner = 0; corner < faces.length; corner++) {
    const own = normals[Math.floor(corner / 3)], size = Math.hypot(...own), sum = [0, 0, 0];
    for (const other of around.get(key(faces[corner]))) {
      if (dot(own, other) >= 0.766 * size * Math.hypot(...other)) other.forEach((value, axis) => { sum[axis] += value; });
    }
    corners.set([...at(faces[corner]), ...sum], corner * 6);
  }
  const vertices = gl.createVertexArray();
  gl.bindVertexArray(vertices);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  for (const index of [0, 1]) {
    gl.enableVertexAttribArray(index);
    gl.vertexAttribPointer(index, 3, gl.FLOAT, false, 24, 12 * index);
  }
  return { vertices, count: faces.length };
}

const OBSTACLE = [0.78, 0.36, 0.36, 1];
const STILL = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function drawSurfaces(side, frames, target, matrix, radius, width, height) {
  const { uniform } = drawer, size = 0.022 * radius;
  if (stage.width !== width || stage.height !== height) Object.assign(stage, { width, height });
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
  gl.uniformMatrix4fv(uniform.camera, false, matrix);
  const bodies = drawer.scenes[side.place].map((body) => [body, body.joint < 0 ? STILL : frames[body.joint], body.colour]);
  bodies.push([drawer.ball, [size, 0, 0, target[0], 0, size, 0, target[1], 0, 0, size, target[2]], [0, 0.62, 0.45, 1]]);
  for (const [x, y, z, a, b, c, radius] of side.now.obstacles) {
    bodies.push([radius ? drawer.ball : drawer.cube, [a || radius, 0, 0, x, 0, b || radius, 0, y, 0, 0, c || radius, z], OBSTACLE]);
  }
  gl.enable(gl.STENCIL_TEST);  // a shadow darkens a pixel once
  gl.stencilFunc(gl.EQUAL, 0, 255);
  gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
  gl.depthMask(false);
  for (const [body, frame] of bodies) drawBody(body, frame, [0, 0, 0, 0.16], 1);
  gl.depthMask(true);
  gl.disable(gl.STENCIL_TEST);
  for (const [body, frame, colour] of bodies) drawBody(body, frame, colour, 0);
}

function drawBody(body, f, colour, shadow) {
  const { uniform } = drawer;
  gl.uniformMatrix4fv(uniform.frame, false, [f[0], f[4], f[8], 0, f[1], f[5], f[9], 0, f[2], f[6], f[10], 0, f[3], f[7], f[11], 1]);
  gl.uniform4fv(uniform.colour, colour);
  gl.uniform1f(uniform.shadow, shadow);
  gl.bindVertexArray(body.vertices);
  gl.drawArrays(gl.TRIANGLES, 0, body.count);
}

// A circle around the target that faces the camera: seen where the hand hides the ball.
function ring(view, target, size = 0.045 * view.radius) {
  const { turn, rise } = view;
  return Array.from({ length: 25 }, (_, index) => {
    const u = size * Math.cos(index * Math.PI / 12), v = size * Math.sin(index * Math.PI / 12);
    return [target[0] - u * Math.sin(turn) - v * Math.sin(rise) * Math.cos(turn),
      target[1] + u * Math.cos(turn) - v * Math.sin(rise) * Math.sin(turn), target[2] + v * Math.cos(rise)];
  });
}

// A way along the edges of a box.
function edges(x, y, z, a, b, c) {
  const corner = (at) => [x + (at & 1 ? a : -a), y + (at & 2 ? b : -b), z + (at & 4 ? c : -c)];
  return [0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4].map(corner);
}

// --- one view --------------------------------------------------------------------------------------------------------

function line(pen, points, matrix, width, height) {
  pen.beginPath();
  let open = false;
  for (const point of points) {
    const at = project(matrix, point, width, height);
    if (at) pen[open ? "lineTo" : "moveTo"](...at);
    open = Boolean(at);
  }
  pen.stroke();
}

// Draws one side at a step into a canvas; undefined where the canvas has no room.
function drawArm(canvas, side, colour, view, step) {
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (!width || !height) return undefined;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const { row, frame, target } = rowAt(side.now, step), frames = place(side.scene, row), tip = origin(frames.at(-1));
  const pen = canvas.getContext("2d"), matrix = camera(view, width, height);
  const draw = (points, stroke, thick, alpha, dash = []) => {
    Object.assign(pen, { strokeStyle: stroke, lineWidth: thick * ratio, globalAlpha: alpha, lineJoin: "round", lineCap: "round" });
    pen.setLineDash(dash.map((length) => length * ratio));
    line(pen, points, matrix, width, height);
    pen.globalAlpha = 1;
  };
  pen.clearRect(0, 0, width, height);
  const edge = 10 ** Math.round(Math.log10(view.radius / 4)), many = Math.ceil(1.3 * view.radius / edge), size = many * edge;
  const [x, y] = view.centre.map((value) => Math.round(value / edge) * edge);
  for (let at = -many; at <= many; at++) {
    draw([[x + at * edge, y - size, 0], [x + at * edge, y + size, 0]], INK, 0.6, 0.22);
    draw([[x - size, y + at * edge, 0], [x + size, y + at * edge, 0]], INK, 0.6, 0.22);
  }
  if (gl) {
    drawSurfaces(side, frames, target, matrix, view.radius, width, height);
    pen.drawImage(stage, 0, 0);
  } else {
    draw([[0, 0, 0], ...frames.map(origin)], INK, 5, 0.8);
    for (const [x, y, z, a, b, c, radius] of side.now.obstacles) draw(radius ? ring(view, [x, y, z], radius) : edges(x, y, z, a, b, c), INK, 1.5, 0.8);
  }
  const way = [...side.now.path.slice(0, Math.floor(frame) + 1), tip];
  draw(side.now.path, colour, 1.5, 0.35);
  draw(way, "#fff", 5, 0.9);
  draw(way, colour, 2.5, 1);
  draw([tip, target], INK, 1, 0.6, [4, 4]);
  draw(ring(view, target), GREEN, 2, 1);
  Object.assign(canvas.dataset, { tip: tip.map((value) => value.toFixed(4)).join(" "), step: step.toFixed(2) });
  return Math.min(Math.round(frame), side.now.rows.length - 1);
}

function drawSide(figure, side, index) {
  const at = drawArm(figure.querySelector("canvas"), side, COLOURS[index], state.view, state.step);
  if (at === undefined) return;
  const step = Math.min(Math.round(state.step), side.now.last);
  figure.querySelector("[data-part=now]").textContent = `step ${step} of ${side.now.last}`;
  figure.querySelector("[data-part=far]").textContent = `${side.error} ${side.now.distance[at].toFixed(3)} ${side.unit}`;
  figure.querySelector("[data-part=sum]").textContent = number(side.now.paid[at]);
}

const number = (value) => (Math.abs(value) >= 1000 ? value.toFixed(0) : value.toPrecision(3)).replace("-", "−");

// --- curves ----------------------------------------------------------------------------------------------------------

function plot(figure, name) {
  const values = state.sides.map((side) => side.now[name]), all = values.flat();
  const low = Math.min(0, ...all), high = Math.max(...all, low + 1e-9), last = Math.max(state.last, 1);
  const y = (value) => (38 - 36 * (value - low) / (high - low)).toFixed(2);
  const curve = (points, colour, dash) => Object.entries({ points, stroke: colour, "stroke-dasharray": dash }).reduce((element, [key, value]) => {
    element.setAttribute(key, value);
    return element;
  }, document.createElementNS("http://www.w3.org/2000/svg", "polyline"));
  figure.querySelector("svg").replaceChildren(
    curve(`0,${y(0)} 100,${y(0)}`, "currentColor", "1 3"),
    ...state.sides.map((side, index) => curve(
      side.now[name].map((value, frame) => `${(100 * side.now.stepOf(frame) / last).toFixed(2)},${y(value)}`).join(" "),
      COLOURS[index], index ? "5 2" : "none")),
    curve("0,0 0,40", "currentColor", "none"),
  );
  figure.querySelector("[data-part=range]").textContent = `${number(low)} to ${number(high)}`;
}

// --- time and controls -----------------------------------------------------------------------------------------------

let waiting = false, before = 0;

function paint() {
  if (!waiting) requestAnimationFrame(tick);
  waiting = true;
}

function tick(now) {
  waiting = false;
  if (state.playing) {
    const seconds = Math.min((now - before) / 1000, 0.1) * Number(part("speed").value);
    state.step = Math.min(state.step + seconds / state.sides[0].period, state.last);
    if (state.step >= state.last) play(false);
    part("scrub").value = state.step;
  }
  before = now;
  views.forEach((figure, index) => state.sides[index] && drawSide(figure, state.sides[index], index));
  for (const name of ["distance", "paid"]) {
    const at = (100 * state.step / Math.max(state.last, 1)).toFixed(2);
    part(name).querySelector("svg").lastElementChild.setAttribute("points", `${at},0 ${at},40`);
  }
  part("scrub").setAttribute("aria-valuetext", `step ${Math.round(state.step)} of ${state.last}`);
  if (state.playing) paint();
}

function play(on) {
  if (on && state.step >= state.last) state.step = 0;
  state.playing = on;
  before = performance.now();
  part("play").textContent = on ? "Pause" : "Play";
  paint();
}

function seek(step) {
  state.step = clamp(step, 0, state.last);
  part("scrub").value = state.step;
  paint();
}

function look(turn, rise, zoom) {
  const view = state.view;
  view.turn += turn;
  view.rise = clamp(view.rise + rise, -0.1, 1.5);
  view.zoom = clamp(view.zoom * zoom, 0.4, 6);
  paint();
}

part("play").addEventListener("click", () => play(!state.playing));
part("scrub").addEventListener("input", (event) => { play(false); seek(Number(event.target.value)); });
part("comparison").addEventListener("change", (event) => choose(Number(event.target.value), data.shows[event.target.value].first));
part("episode").addEventListener("change", (event) => choose(state.show, Number(event.target.value)));
const TURNS = { left: [-0.3, 0, 1], right: [0.3, 0, 1], above: [0, 0.2, 1], below: [0, -0.2, 1], nearer: [0, 0, 1.25], farther: [0, 0, 0.8] };
for (const [name, by] of Object.entries(TURNS)) part(name).addEventListener("click", () => look(...by));
part("reset").addEventListener("click", () => { Object.assign(state.view, HOME); paint(); });
for (const canvas of root.querySelectorAll(".replay-views canvas")) {
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) look(-event.movementX * 0.008, event.movementY * 0.006, 1);
  });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;  // the page scrolls
    event.preventDefault();
    look(0, 0, Math.exp(-event.deltaY * 0.002));
  }, { passive: false });
  new ResizeObserver(paint).observe(canvas);
}

// --- stills: the end of the typical pair beside each answer, which a click plays -----------------------------------------

const SHOWN_FOR = 3;  // seconds that a whole episode takes

function prepareStill(still) {
  const show = Number(still.dataset.show), episode = data.shows[show].first;
  let sides = null, last = 0, view = null;  // unpacked when it is first seen: a page may have many
  const canvases = [...still.querySelectorAll("canvas")];
  for (const part of still.querySelectorAll("[hidden]")) part.hidden = false;
  const draw = (step) => sides.forEach((side, index) => drawArm(canvases[index], side, COLOURS[index], view, Math.min(step, side.now.last)));
  const end = () => {
    if (!canvases[0].clientWidth) return;
    if (!sides) {
      sides = sidesOf(show, episode);
      last = lastOf(sides);
      view = { ...HOME, ...framed(sides) };
    }
    draw(last);
  };
  let since = null;
  const run = (now) => {
    since ??= now;
    const seconds = Math.min(SHOWN_FOR, Math.max(1, last * sides[0].period)), share = Math.min((now - since) / 1000 / seconds, 1);
    draw(share * last);
    if (share < 1) requestAnimationFrame(run);
  };
  still.querySelector("button").addEventListener("click", () => { since = null; requestAnimationFrame(run); });
  for (const canvas of canvases) new ResizeObserver(end).observe(canvas);
}
for (const still of document.querySelectorAll(".still[data-show]")) prepareStill(still);

// A link to #replay-2 shows the second comparison, one to #replay-2-7-3 its episode 7 of seed 3.
function follow() {
  const [, show, episode, seed] = /^#replay-(\d+)(?:-(\d+))?(?:-(\d+))?$/.exec(location.hash) ?? [];
  if (show === undefined || !data.shows[show - 1]) return false;
  const shown = data.shows[show - 1];
  const index = shown.numbers.findIndex((number, at) => number === Number(episode) && [undefined, String(shown.sides[0].seeds[at])].includes(seed));
  choose(show - 1, index < 0 ? shown.first : index);
  root.closest("details")?.setAttribute("open", "");
  root.scrollIntoView();
  part("play").focus({ preventScroll: true });
  return true;
}

addEventListener("hashchange", follow);
addEventListener("click", (event) => {  // a link to where the address leads already changes no address
  const link = event.target.closest('a[href^="#replay-"]');
  if (link && link.hash === location.hash) follow();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
if (!follow()) choose(0, data.shows[0].first);
})();
