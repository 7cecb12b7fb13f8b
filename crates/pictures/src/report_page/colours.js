// Colour maps: viridis for speeds, blue to orange for pressures and vorticities.

const VIRIDIS = ("440154 481a6c 472f7d 414487 39568c 31688e 2a788e 23888e 1f988b 22a884 35b779 " +
  "54c568 7ad151 a5db36 d2e21b fde725").split(" ");
const BLUE_TO_ORANGE = "0072b2 e8e8e8 d55e00".split(" ");

/** Red, green, blue of a map at a place from 0 to 1. */
function mapColour(map, place) {
  const at = Math.min(1, Math.max(0, place)) * (map.length - 1);
  const below = Math.min(map.length - 2, Math.floor(at));
  const part = (text, k) => parseInt(text.slice(2 * k, 2 * k + 2), 16);
  return [0, 1, 2].map((k) => {
    const [a, b] = [part(map[below], k), part(map[below + 1], k)];
    return Math.round(a + (at - below) * (b - a));
  });
}

/** A table of 256 colours of a map. */
function colourTable(map) {
  return Array.from({ length: 256 }, (_, k) => mapColour(map, k / 255));
}

/** The value of a colour of the style sheet. */
function styleColour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** A colour like #0072b2 as three numbers from 0 to 1. */
function unitColour(hex) {
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
}

/** Calls `draw` when the page turns dark or light. */
function onThemeChange(draw) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}
