// The flow in a plane: colours, streamlines, outlines of the bodies.

const slices = run.slices.map((data) => {
  const count = data.columns * data.rows;
  const steps = unpacked(data.velocity, Int16Array);
  const isFluid = (k) => steps[k] !== -32768;
  const speed = Float32Array.from({ length: count }, (_, k) => isFluid(k)
    ? data.unit * Math.hypot(steps[k], steps[count + k], steps[2 * count + k]) : NaN);
  const pressureSteps = data.pressure && unpacked(data.pressure, Int16Array);
  const pressure = pressureSteps && Float32Array.from({ length: count }, (_, k) =>
    pressureSteps[k] === -32768 ? NaN : data.pressureUnit * pressureSteps[k]);
  const component = (number) => Float32Array.from({ length: count }, (_, k) =>
    isFluid(k) ? data.unit * steps[number * count + k] : NaN);
  const vorticity = vorticityTowardsViewer(component(0), component(1), data);
  const shares = (text) => Array.from(unpacked(text, Uint16Array), (share) => share / 65535);
  return {
    ...data, speed, vorticity, pressure,
    lines: data.lines.map(shares),
    walls: unpacked(data.walls, Float32Array),
    outlines: data.outlines.map(({ body, points }) => ({ body, points: unpacked(points, Float32Array) })),
    images: {},
  };
});

const quantities = {
  speed: { map: colourTable(VIRIDIS), low: 0, high: 0, lines: "255, 255, 255" },
  vorticity: { map: colourTable(BLUE_TO_ORANGE), low: 0, high: 0, lines: "40, 40, 40" },
  pressure: { map: colourTable(BLUE_TO_ORANGE), low: 0, high: 0, lines: "40, 40, 40" },
};
for (const slice of slices) {
  for (const value of slice.speed) if (value > quantities.speed.high) quantities.speed.high = value;
  for (const name of ["vorticity", "pressure"]) {
    const range = quantities[name];
    for (const value of slice[name] ?? []) {
      if (Math.abs(value) > range.high) [range.low, range.high] = [-Math.abs(value), Math.abs(value)];
    }
  }
}

/** Vorticity towards the viewer: central differences, one-sided next to bodies and edges. */
function vorticityTowardsViewer(right, up, { columns, rows, plane }) {
  const [dx, dy] = [plane.width / (columns - 1), plane.height / (rows - 1)];
  return right.map((_, k) => {
    const [column, row] = [k % columns, Math.floor(k / columns)];
    const slope = (values, stride, isFirst, isLast, step) => {
      const before = isFirst || Number.isNaN(values[k - stride]) ? k : k - stride;
      const after = isLast || Number.isNaN(values[k + stride]) ? k : k + stride;
      return (values[after] - values[before]) / ((after - before) / stride * step);
    };
    return slope(up, 1, column === 0, column === columns - 1, dx)
      - slope(right, columns, row === 0, row === rows - 1, dy);
  });
}

/** The slice whose time is nearest. */
function nearestSlice(time) {
  const off = (slice) => Math.abs(slice.time - time);
  return slices.reduce((best, slice) => (!best || off(slice) < off(best) ? slice : best), null);
}

/** Values continued by one grid point, so that colours reach the outlines of the bodies. */
function continued(values, columns, rows) {
  return values.map((value, k) => {
    if (!Number.isNaN(value)) return value;
    const [column, row] = [k % columns, Math.floor(k / columns)];
    let sum = 0, count = 0;
    for (let up = -1; up <= 1; up++) {
      for (let right = -1; right <= 1; right++) {
        const [c, r] = [column + right, row + up];
        const near = c >= 0 && c < columns && r >= 0 && r < rows ? values[r * columns + c] : NaN;
        if (!Number.isNaN(near)) { sum += near; count += 1; }
      }
    }
    return count ? sum / count : NaN;
  });
}

/** A canvas with one pixel per grid point. */
function colourImage(slice, name) {
  if (slice.images[name]) return slice.images[name];
  const { map, low, high } = quantities[name];
  const { columns, rows } = slice;
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext("2d");
  const image = context.createImageData(columns, rows);
  continued(slice[name], columns, rows).forEach((value, k) => {
    if (Number.isNaN(value)) return;
    const [column, row] = [k % columns, rows - 1 - Math.floor(k / columns)];
    const place = Math.round(255 * (value - low) / (high - low || 1));
    image.data.set([...map[place], 255], 4 * (row * columns + column));
  });
  context.putImageData(image, 0, 0);
  slice.images[name] = canvas;
  return canvas;
}

/** Draws a slice without axes into a rectangle. */
function drawSlice(context, slice, name, x, y, width, height, pixel) {
  const { columns, rows } = slice;
  const at = (points, k) => [x + width * points[k], y + height * (1 - points[k + 1])];
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  // The outer grid points lie on the edges.
  const [dx, dy] = [width / (columns - 1), height / (rows - 1)];
  context.imageSmoothingQuality = "high";
  context.drawImage(colourImage(slice, name), x - dx / 2, y - dy / 2, width + dx, height + dy);
  const colour = quantities[name].lines;
  context.lineWidth = pixel;
  context.strokeStyle = context.fillStyle = `rgba(${colour}, 0.85)`;
  for (const line of slice.lines) {
    context.beginPath();
    for (let k = 0; k < line.length; k += 2) context.lineTo(...at(line, k));
    context.stroke();
    drawArrow(context, at, line, 4 * pixel);
  }
  context.strokeStyle = styleColour("--ink");
  context.lineWidth = 1.5 * pixel;
  context.beginPath();
  for (let k = 0; k < slice.walls.length; k += 4) {
    context.moveTo(...at(slice.walls, k));
    context.lineTo(...at(slice.walls, k + 2));
  }
  context.stroke();
  context.strokeStyle = "#ffffff";
  context.lineWidth = 1.25 * pixel;
  for (const { body, points } of slice.outlines) {
    context.fillStyle = run.bodies[body].colour;
    context.beginPath();
    for (let k = 0; k < points.length; k += 2) context.lineTo(...at(points, k));
    context.closePath();
    context.fill();
    context.stroke();
  }
  context.restore();
}

/** An arrow head in the middle of a line. */
function drawArrow(context, at, line, size) {
  const middle = 2 * Math.floor(line.length / 4);
  if (middle < 2) return;
  const [[x0, y0], [x, y]] = [at(line, middle - 2), at(line, middle)];
  const norm = Math.hypot(x - x0, y - y0);
  if (!norm) return;
  const [a, b] = [size * (x - x0) / norm, size * (y - y0) / norm];
  context.beginPath();
  context.moveTo(x + 1.4 * a, y + 1.4 * b);
  context.lineTo(x - a - 0.8 * b, y - b + 0.8 * a);
  context.lineTo(x - a + 0.8 * b, y - b - 0.8 * a);
  context.fill();
}

/** The name of a direction: a coordinate, or the unit vector. */
function directionName(e) {
  const axis = e.findIndex((c) => Math.abs(c - 1) < 5e-3);
  return axis >= 0 ? "xyz"[axis] : `along (${e.map((c) => digits(c, 2)).join(", ")})`;
}

{
  const canvas = document.getElementById("slice");
  const note = document.getElementById("slice-note");
  const choice = document.getElementById("quantity");
  let shown = null, frame = null;

  const draw = () => {
    const pixel = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [Math.round(width * pixel), Math.round(height * pixel)];
    const context = canvas.getContext("2d");
    context.scale(pixel, pixel);
    const { right, up, centre } = shown.plane;
    const space = { left: 50, right: 76, above: 26, below: 40 };
    const scale = Math.min((width - space.left - space.right) / shown.plane.width,
      (height - space.above - space.below) / shown.plane.height);
    const [w, h] = [scale * shown.plane.width, scale * shown.plane.height];
    const x = space.left + (width - space.left - space.right - w) / 2;
    const y = space.above + (height - space.above - space.below - h) / 2;
    frame = { x, y, w, h };
    drawSlice(context, shown, choice.value, x, y, w, h, 1);
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    context.fillStyle = context.strokeStyle = styleColour("--ink");
    context.font = "13px system-ui, 'DejaVu Sans', sans-serif";
    context.lineWidth = 1;
    context.strokeRect(x, y, w, h);
    const [left, bottom] = [dot(centre, right) - shown.plane.width / 2, dot(centre, up) - shown.plane.height / 2];
    const mark = (text, px, py, dx, dy, align, baseline) => {
      context.beginPath();
      context.moveTo(px, py);
      context.lineTo(px + dx, py + dy);
      context.stroke();
      [context.textAlign, context.textBaseline] = [align, baseline];
      context.fillText(text, px + 1.6 * dx, py + 1.6 * dy);
    };
    for (const tick of ticks(left, left + shown.plane.width, Math.max(2, w / 70))) {
      mark(tickText(tick), x + scale * (tick - left), y + h, 0, 5, "center", "top");
    }
    for (const tick of ticks(bottom, bottom + shown.plane.height, Math.max(2, h / 50))) {
      mark(tickText(tick), x, y + h - scale * (tick - bottom), -5, 0, "right", "middle");
    }
    [context.textAlign, context.textBaseline] = ["center", "top"];
    context.fillText(directionName(right), x + w / 2, y + h + 24);
    [context.textAlign, context.textBaseline] = ["left", "bottom"];
    context.fillText(directionName(up), Math.max(4, x - 30), y - 6);
    const { map, low, high } = quantities[choice.value];
    const bar = x + w + 14;
    for (let k = 0; k < 256; k++) {
      context.fillStyle = `rgb(${map[k]})`;
      context.fillRect(bar, y + h * (1 - (k + 1) / 256), 14, h / 256 + 0.6);
    }
    context.fillStyle = styleColour("--ink");
    for (const tick of high > low ? ticks(low, high, Math.max(2, h / 50)) : []) {
      mark(tickText(tick), bar + 14, y + h * (1 - (tick - low) / (high - low)), 5, 0, "left", "middle");
    }
    context.textBaseline = "bottom";
    context.textAlign = "left";
    context.fillText(choice.value, bar, y - 6);
    const text = `Flow at t = ${digits(shown.time, 3)}, in the laboratory frame.`;
    note.textContent = text;
    canvas.setAttribute("aria-label", `${text} Streamlines, ${choice.value} as colour from ` +
      `${digits(low, 3)} to ${digits(high, 3)}.`);
  };

  if (slices.length === 0) {
    document.getElementById("slice-figure").hidden = true;
    document.getElementById("show-flow").closest("label").hidden = true;
    document.getElementById("view3d-note").textContent +=
      ` The flow is not shown: ${run.missing ?? "it was not stored"}.`;
  } else {
    if (run.missing) {
      document.getElementById("view3d-note").textContent +=
        ` Some of the flow is not shown: ${run.missing}.`;
    }
    choice.querySelector("[value=pressure]").hidden = !slices.every((slice) => slice.pressure);
    player.onChange((time) => {
      const slice = nearestSlice(time);
      if (slice === shown) return;
      shown = slice;
      draw();
    });
    choice.addEventListener("change", () => { draw(); player.set(player.time); });
    new ResizeObserver(draw).observe(canvas);
    onThemeChange(draw);
    canvas.addEventListener("pointermove", (event) => {
      const { columns, rows } = shown;
      const column = Math.round((event.offsetX - frame.x) / frame.w * (columns - 1));
      const row = Math.round((1 - (event.offsetY - frame.y) / frame.h) * (rows - 1));
      if (column < 0 || column >= columns || row < 0 || row >= rows) return;
      const value = shown[choice.value][row * columns + column];
      if (!Number.isNaN(value)) note.textContent = `${choice.value} at the pointer: ${digits(value, 3)}`;
    });
    canvas.addEventListener("pointerleave", draw);
  }
}
