// The data of the run, and the time that all pictures share.

const run = JSON.parse(document.getElementById("run-data").textContent);

/** The typed array of a base64 text. */
function unpacked(text, Type) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Type(bytes.buffer);
}

/** A number with a few digits, without an exponent where it is readable. */
function digits(value, count = 4) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e-3 && size < 1e5 ? value.toPrecision(count) : value.toExponential(count - 1);
  return text.replace("-", "\u2212");
}

/** Round numbers from low to high, about as many as wanted. */
function ticks(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= 0.999 * rough);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}

/** A tick as text: without the rounding error of a multiple. */
function tickText(value) {
  return String(Number(value.toPrecision(6))).replace("-", "\u2212");
}

const track = {
  times: unpacked(run.times, Float32Array),
  poses: unpacked(run.poses, Float32Array),
};

/** The index of the last time that is not after `time`, and the place of `time` behind it. */
function stepAt(time) {
  const times = track.times;
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle; else high = middle;
  }
  const width = times[high] - times[low];
  return { low, high, share: width > 0 ? Math.min(1, Math.max(0, (time - times[low]) / width)) : 0 };
}

/** Position and quaternion of a body at a time. */
function poseAt(body, time) {
  const { low, high, share } = stepAt(time);
  const [a, b] = [low, high].map((step) => 7 * (step * run.bodies.length + body));
  const pose = [];
  let dot = 0;
  for (let k = 3; k < 7; k++) dot += track.poses[a + k] * track.poses[b + k];
  for (let k = 0; k < 7; k++) {
    const sign = k > 2 && dot < 0 ? -1 : 1;
    pose.push((1 - share) * track.poses[a + k] + share * sign * track.poses[b + k]);
  }
  const norm = Math.hypot(...pose.slice(3));
  return { x: pose.slice(0, 3), q: pose.slice(3).map((c) => c / norm) };
}

/** The time, and the functions that draw when it changes. */
const player = {
  time: 0,
  playing: false,
  listeners: [],

  set(time) {
    this.time = Math.min(run.duration, Math.max(0, time));
    this.listeners.forEach((listener) => listener(this.time));
  },

  /** Draws at every change of the time, and now. */
  onChange(listener) {
    this.listeners.push(listener);
    listener(this.time);
  },

  play(on) {
    if (on && this.time >= run.duration) this.set(0);
    this.playing = on;
    if (on) requestAnimationFrame((now) => this.frame(now, now));
    document.getElementById("play").textContent = on ? "Pause" : "Play";
    document.getElementById("play").setAttribute("aria-pressed", String(on));
  },

  frame(now, before) {
    if (!this.playing) return;
    // A cycle takes six seconds at speed 1.
    const speed = Number(document.getElementById("rate").value) * run.cycle / 6;
    this.set(this.time + speed * (now - before) / 1000);
    if (this.time >= run.duration) this.play(false);
    else requestAnimationFrame((next) => this.frame(next, now));
  },
};

// Pictures are as wide for their height as the window of the flow, within limits.
document.documentElement.style.setProperty("--aspect",
  String(Math.min(1.8, Math.max(1.15, 0.88 * run.view.width / run.view.height))));

{
  const slider = document.getElementById("time");
  const clock = document.getElementById("clock");
  document.getElementById("play").addEventListener("click", () => player.play(!player.playing));
  slider.addEventListener("input", () => {
    player.play(false);
    player.set(run.duration * slider.value / 1000);
  });
  player.onChange((time) => {
    slider.value = Math.round(1000 * time / run.duration);
    slider.setAttribute("aria-valuetext", `time ${digits(time, 3)}`);
    clock.textContent = `t = ${time.toFixed(Math.max(0, 2 - Math.floor(Math.log10(run.cycle))))}`;
  });
  document.addEventListener("keydown", (event) => {
    if (event.key !== " " || event.target.closest("button, select, input, summary, pre")) return;
    event.preventDefault();
    player.play(!player.playing);
  });
  const { shown, all } = run.cycles;
  if (shown < all) {
    document.getElementById("cycles-note").textContent =
      `Pictures and curves show ${shown} of ${all} cycles; the tables below are of the whole run.`;
  }
}
