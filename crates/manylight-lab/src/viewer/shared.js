"use strict";
// What pages with images share: elements, pixels as half floats, sRGB, light groups, pan and zoom.

// Elements.

function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

// Pixels.

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

function floatOfHalf(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}
const floats = Float32Array.from({ length: 65536 }, (_, bits) => floatOfHalf(bits));

/** Values of half floats in base64. */
function valuesOf(base64) {
  const bytes = bytesOf(base64);
  const halves = new Uint16Array(bytes.buffer, 0, bytes.length / 2);
  return Float32Array.from(halves, (bits) => floats[bits]);
}

const encode = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const encoded = Uint8ClampedArray.from({ length: 4097 }, (_, i) => Math.round(255 * encode(i / 4096)));

/** Writes linear RGB values times `gain` as sRGB bytes with alpha; NaN in magenta. */
function fillImage(out, rgb, gain) {
  for (let i = 0, o = 0; i < rgb.length; i += 3, o += 4) {
    for (let c = 0; c < 3; c++) {
      const v = Math.min(Math.max(rgb[i + c] * gain, 0), 1);
      out[o + c] = encoded[Math.round(4096 * v) || 0];
    }
    if (Number.isNaN(rgb[i] + rgb[i + 1] + rgb[i + 2])) out.set([255, 0, 255], o);
    out[o + 3] = 255;
  }
}

const signedText = (number) => `${number > 0 ? "+" : ""}${number}`;

// Light groups. Factors are a map from the name of a group to [red, green, blue]; groups as rendered are left out.

/** The light of no group, relative to the picture, below which it counts as the rounding of half floats. */
const ROUNDING = 2 ** -9;
const AS_RENDERED = [1, 1, 1];

/** The sum of light groups, each [name, values], times their factors, and the light of `picture`, their sum, that belongs to none. */
function relit(picture, groups, factors) {
  const weighed = new Float32Array(picture.length);
  const sum = new Float32Array(picture.length);
  for (const [name, values] of groups) {
    const factor = factors.get(name) ?? AS_RENDERED;
    for (let i = 0; i < values.length; i++) {
      sum[i] += values[i];
      weighed[i] += factor[i % 3] * values[i];
    }
  }
  for (let i = 0; i < picture.length; i++) {
    const rest = picture[i] - sum[i];
    if (rest > ROUNDING * Math.abs(picture[i])) weighed[i] += rest;
  }
  return weighed;
}

/** Ends of the sliders, in stops. The lower end is no light. */
const OFF = -4;
const BRIGHTEST = 4;

const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);

/** A slider and a color for each of these light groups. `changed` is called with the factors. */
function lightPanel(names, changed) {
  const words = element("code");
  const tell = () => {
    const factors = new Map();
    for (const { name, stops, color, text } of rows) {
      const strength = Number(stops.value) <= OFF ? 0 : 2 ** Number(stops.value);
      text.textContent = strength === 0 ? "off" : Number(strength.toPrecision(3));
      const channels = [1, 3, 5].map((i) => linear(Number.parseInt(color.value.slice(i, i + 2), 16) / 255));
      const factor = channels.map((v) => Number((strength * v).toPrecision(3)));
      if (factor.some((v) => v !== 1)) factors.set(name, factor);
    }
    const option = ([name, factor]) => `--group ${name}=${new Set(factor).size === 1 ? factor[0] : factor.join(",")}`;
    words.textContent = factors.size > 0 ? `manylight relight ${[...factors].map(option).join(" ")}` : "";
    changed(factors);
  };
  const row = (name) => ({
    name,
    stops: element("input", { type: "range", min: OFF, max: BRIGHTEST, step: 0.25, value: 0, "data-light": name, "aria-label": `Strength of ${name}`, oninput: tell }),
    color: element("input", { type: "color", value: "#ffffff", "data-light": name, "aria-label": `Color of ${name}`, oninput: tell }),
    text: element("output", {}, "1"),
  });
  const rows = names.map(row);
  const reset = () => {
    for (const { stops, color } of rows) [stops.value, color.value] = [0, "#ffffff"];
    tell();
  };
  return element("div", { class: "lights" },
    ...rows.map(({ name, stops, color, text }) => element("label", {}, name, stops, color, text)),
    element("button", { type: "button", onclick: reset }, "As rendered"),
    words);
}

// Pan and zoom. A place says where an image is in its view: `scale` in CSS pixels per image pixel; `x`, `y` of its upper left corner in CSS
// pixels; `fitted` if it follows the size of the view; `at`, the position of the pointer in the view or null.

const LEAST_ZOOM = 0.1;
const MOST_ZOOM = 64;

/** Makes an image as large as its view allows, in the middle. */
function fit(place, view, width, height) {
  const box = view.getBoundingClientRect();
  place.scale = Math.min(box.width / width, box.height / height);
  place.x = (box.width - width * place.scale) / 2;
  place.y = (box.height - height * place.scale) / 2;
}

/** Zooms about the point `x`, `y` of the view. */
function zoomTo(place, wanted, x, y) {
  const scale = Math.min(Math.max(wanted, LEAST_ZOOM), MOST_ZOOM);
  place.x = x - ((x - place.x) * scale) / place.scale;
  place.y = y - ((y - place.y) * scale) / place.scale;
  Object.assign(place, { scale, fitted: false });
}

/** Position of a pointer in its view, in CSS pixels. */
function placeIn(view, event) {
  const box = view.getBoundingClientRect();
  return { x: event.clientX - box.left, y: event.clientY - box.top };
}

/** The pixel under the pointer; null outside of the image. */
function pixelAt(place, width, height) {
  if (!place.at) return null;
  const column = Math.floor((place.at.x - place.x) / place.scale);
  const row = Math.floor((place.at.y - place.y) / place.scale);
  const isInside = column >= 0 && row >= 0 && column < width && row < height;
  return isInside ? { column, row } : null;
}

/** Pans and zooms by drags, pinches, and the wheel. Calls `moved` when the image has moved, `pointed` when only the pointer has, and `fit` for
 * a double click. */
function panAndZoom(canvas, place, { moved, pointed, fit }) {
  const pointers = new Map();
  const middleOf = () => {
    const all = [...pointers.values()];
    const x = all.reduce((sum, p) => sum + p.x, 0) / all.length;
    const y = all.reduce((sum, p) => sum + p.y, 0) / all.length;
    const spread = all.length > 1 ? Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) : 0;
    return { x, y, spread };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, placeIn(canvas, event));
  });
  canvas.addEventListener("pointermove", (event) => {
    place.at = placeIn(canvas, event);
    if (!pointers.has(event.pointerId)) return pointed();
    const before = middleOf();
    pointers.set(event.pointerId, place.at);
    const after = middleOf();
    place.x += after.x - before.x;
    place.y += after.y - before.y;
    place.fitted = false;
    if (before.spread > 0 && after.spread > 0) zoomTo(place, (place.scale * after.spread) / before.spread, after.x, after.y);
    moved();
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("pointerleave", () => {
    place.at = null;
    pointed();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { x, y } = placeIn(canvas, event);
    zoomTo(place, place.scale * 2 ** (-event.deltaY / 300), x, y);
    moved();
  }, { passive: false });
  canvas.addEventListener("dblclick", fit);
}

/** Paints bitmaps into vertical strips [bitmap, left, right] of a view. */
function paint(canvas, place, strips) {
  const ratio = devicePixelRatio;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.imageSmoothingEnabled = place.scale * ratio < 1;
  for (const [bitmap, from, to] of strips) {
    context.save();
    context.beginPath();
    context.rect(from, 0, to - from, height);
    context.clip();
    context.drawImage(bitmap, place.x, place.y, bitmap.width * place.scale, bitmap.height * place.scale);
    context.restore();
  }
}
