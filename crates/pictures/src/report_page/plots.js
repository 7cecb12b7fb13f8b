// Curves over time, with a line at the time of the player.

{
  const SVG = "http://www.w3.org/2000/svg";
  const [WIDTH, HEIGHT] = [640, 280];
  const space = { left: 70, right: 12, above: 24, below: 44 };

  const element = (parent, name, attributes, text) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    parent.append(made);
    return made;
  };

  /** A colour that is seen on the paper: dark ones are light in the dark mode. */
  const visible = (colour) => (colour === "#282828" ? "var(--ink)" : colour);

  const drawPlot = (plot) => {
    const box = document.createElement("div");
    box.className = "plot";
    const title = document.createElement("h3");
    title.textContent = plot.title;
    const series = plot.series.map((one) => ({ ...one, values: unpacked(one.values, Float32Array) }));
    let [low, high] = [Infinity, -Infinity];
    for (const { values } of series) {
      for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
    }
    const margin = 0.06 * (high - low) || Math.abs(high) || 1;
    [low, high] = [low - margin, high + margin];
    const x = (time) => space.left + (WIDTH - space.left - space.right) * time / run.duration;
    const y = (value) => HEIGHT - space.below - (HEIGHT - space.above - space.below) * (value - low) / (high - low);
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
    svg.setAttribute("role", "img");
    const ends = series.map(({ name, values }) => `${name} ${digits(values[values.length - 1])}`);
    svg.setAttribute("aria-label", `${plot.title}, ${plot.unit}, over time. At the end: ${ends.join(", ")}.`);
    const [top, bottom] = [space.above, HEIGHT - space.below];
    run.phases.forEach(({ begin, end, name }, k) => {
      if (k % 2) element(svg, "rect", { class: "band", x: x(begin), y: top, width: x(end) - x(begin), height: bottom - top });
      const room = (x(end) - x(begin)) / 7;
      if (name && name.length <= room) {
        element(svg, "text", { class: "phase", x: (x(begin) + x(end)) / 2, y: top - 8, "text-anchor": "middle" }, name);
      }
    });
    for (const tick of ticks(low, high, 5)) {
      element(svg, "line", { class: "grid", x1: space.left, x2: WIDTH - space.right, y1: y(tick), y2: y(tick) });
      element(svg, "text", { x: space.left - 8, y: y(tick) + 4, "text-anchor": "end" }, tickText(tick));
    }
    for (const tick of ticks(0, run.duration, 8)) {
      element(svg, "line", { class: "axis", x1: x(tick), x2: x(tick), y1: bottom, y2: bottom + 5 });
      element(svg, "text", { x: x(tick), y: bottom + 19, "text-anchor": "middle" }, tickText(tick));
    }
    element(svg, "line", { class: "axis", x1: space.left, x2: WIDTH - space.right, y1: bottom, y2: bottom });
    element(svg, "text", { x: (space.left + WIDTH - space.right) / 2, y: HEIGHT - 6, "text-anchor": "middle" },
      "time (the scene's unit)");
    for (const { values, colour } of series) {
      const points = Array.from(values, (value, k) => `${x(track.times[k]).toFixed(1)},${y(value).toFixed(1)}`);
      element(svg, "polyline", { class: "curve", points: points.join(" "), style: `stroke: ${visible(colour)}` });
    }
    const cursor = element(svg, "line", { class: "cursor", y1: top, y2: bottom });
    const dots = series.map(({ colour }) => element(svg, "circle", { r: 4, style: `fill: ${visible(colour)}` }));
    const legend = document.createElement("ul");
    legend.className = "legend";
    const readings = series.map(({ name, colour }) => {
      const [entry, swatch, value] = ["li", "i", "b"].map((tag) => document.createElement(tag));
      swatch.style.background = visible(colour);
      entry.append(swatch, `${name} `, value);
      legend.append(entry);
      return value;
    });
    const unit = Object.assign(document.createElement("p"), { className: "note", textContent: plot.unit });
    box.append(title, legend, unit, svg);
    document.getElementById("plots").append(box);
    player.onChange((time) => {
      cursor.setAttribute("x1", x(time));
      cursor.setAttribute("x2", x(time));
      const { low: from, high: to, share } = stepAt(time);
      series.forEach(({ values }, k) => {
        const value = (1 - share) * values[from] + share * values[to];
        dots[k].setAttribute("cx", x(time));
        dots[k].setAttribute("cy", y(value));
        readings[k].textContent = digits(value);
      });
    });
    const follow = (event) => {
      if (event.type === "pointermove" && !event.buttons) return;
      const bounds = svg.getBoundingClientRect();
      const at = (event.clientX - bounds.left) * WIDTH / bounds.width;
      player.play(false);
      player.set(run.duration * (at - space.left) / (WIDTH - space.left - space.right));
    };
    svg.addEventListener("pointerdown", follow);
    svg.addEventListener("pointermove", follow);
  };

  run.plots.forEach(drawPlot);
}
