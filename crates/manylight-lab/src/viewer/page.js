"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);

  // Pixels.

  /** Decodes the pixels of an image: linear values by the chosen lights, HDR-FLIP as bytes, error bars. Keeps a cache of bitmaps. */
  function decoded(image) {
    if (!image.rendered) {
      image.rendered = valuesOf(image.rgb);
      image.seen = image.flip ? bytesOf(image.flip) : null;
      image.barValues = image.bars ? valuesOf(image.bars) : null;
    }
    if (image.factors !== state.factors) {
      image.factors = state.factors;
      image.values = relitValues(image);
      image.mean = undefined;
      image.bitmaps = new Map();
    }
    return image;
  }

  /** Values of an image by the chosen lights; as rendered if it has no light groups. */
  function relitValues(image) {
    if (state.factors.size === 0 || !image.lights) return image.rendered;
    image.groups ??= image.lights.map(({ name, rgb }) => [name, valuesOf(rgb)]);
    image.added ??= image.sum ? valuesOf(image.sum) : image.rendered;
    return relit(image.added, image.groups, state.factors);
  }

  /** `mode`, where it is known: HDR-FLIP and error bars are those of the lights as rendered. */
  const knownMode = (mode) => (["flip", "bars"].includes(mode) && state.factors.size > 0 ? "image" : mode);

  /** `mode`, where it is known of a decoded image. The reference has no error, and some images have no error bars. */
  const modeOf = (image, mode) => (image.seen && (mode !== "bars" || image.barValues) ? knownMode(mode) : "image");

  const isLoaded = (group) => group.images[0].rgb !== undefined;

  /** Starts to load the pixels of a group; their script calls `manylight.put`. */
  function load(group) {
    if (group.asked) return;
    group.asked = true;
    const failed = () => (readout.textContent = `${group.file} is missing`);
    document.head.append(element("script", { src: group.file, onerror: failed }));
  }

  window.manylight = {
    put(k, pixels) {
      const group = data.groups[k];
      group.images.forEach((image, i) => Object.assign(image, pixels[i]));
      if (group === state.group) draw();
    },
  };

  const luminance = (rgb, i) => 0.2126 * rgb[i] + 0.7152 * rgb[i + 1] + 0.0722 * rgb[i + 2];

  function meanOf(image) {
    if (image.mean === undefined) {
      let sum = 0;
      let count = 0;
      for (const v of image.values) {
        if (Number.isFinite(v)) {
          sum += v;
          count++;
        }
      }
      image.mean = sum / Math.max(count, 1);
    }
    return image.mean;
  }

  // Errors of pixels.

  // Weight of the squared mean in the denominator, as in relMSE.
  const FLOOR = 0.01;

  /** Square root of the relMSE of a pixel; `i` is the index of its first value, `mean` the mean of the reference. */
  function relativeError(x, r, mean, i) {
    let sum = 0;
    for (let c = 0; c < 3; c++) {
      const difference = x[i + c] - r[i + c];
      const scale = r[i + c] * r[i + c] + FLOOR * mean * mean;
      if (difference !== 0) sum += (difference * difference) / scale;
    }
    return Math.sqrt(sum / 3);
  }

  /** Difference in luminance relative to the reference, which counts as at least 0.1 of its mean. */
  function signedError(x, r, mean, i) {
    const own = luminance(r, i);
    return (luminance(x, i) - own) / Math.max(own, 0.1 * mean, 1e-20);
  }

  // Colors.

  const HEAT = [
    [0, 0, 0],
    [60, 15, 100],
    [170, 40, 100],
    [240, 110, 50],
    [252, 200, 70],
    [255, 255, 230],
  ];
  const SIGNED = [
    [80, 170, 255],
    [20, 60, 140],
    [0, 0, 0],
    [150, 40, 20],
    [255, 150, 80],
  ];

  /** Color at `t` in [0, 1] on a scale of colors at even steps. */
  function between(colors, t) {
    const place = Math.min(Math.max(t, 0), 1) * (colors.length - 1);
    const k = Math.min(Math.floor(place), colors.length - 2);
    return [0, 1, 2].map((c) => colors[k][c] + (place - k) * (colors[k + 1][c] - colors[k][c]));
  }

  const table = (colors) => Array.from({ length: 256 }, (_, i) => between(colors, i / 255));
  /** Relative error at the lower end of the logarithmic scale; the upper end is 1. */
  const LEAST_ERROR = 0.01;
  const MODES = {
    image: { label: "Image" },
    error: {
      label: "Relative error",
      colors: table(HEAT),
      scale: ["1 %", "100 %"],
      place: (x, r, mean, i) => 1 + Math.log10(relativeError(x.values, r.values, mean, i)) / -Math.log10(LEAST_ERROR),
    },
    difference: {
      label: "Difference",
      colors: table(SIGNED),
      scale: ["-50 %", "+50 %"],
      place: (x, r, mean, i) => 0.5 + signedError(x.values, r.values, mean, i),
    },
    flip: {
      label: "HDR-FLIP",
      colors: table(HEAT),
      scale: ["0", "1"],
      place: (x, r, mean, i) => x.seen[i / 3] / 255,
    },
    bars: {
      label: "Error bars",
      colors: table(SIGNED),
      scale: ["-2 bars", "+2 bars"],
      place: (x, r, mean, i) => 0.5 + differenceInBars(x, r, i) / 4,
    },
  };
  if (!data.groups.some((group) => group.images.some((image) => image.has_bars))) delete MODES.bars;

  /** The difference of the channel that is farthest off, in error bars; 0 without a difference. */
  function differenceInBars(x, r, i) {
    const channels = [0, 1, 2].map((c) => (x.values[i + c] - r.values[i + c]) / x.barValues[i + c] || 0);
    return channels.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a));
  }

  function bitmapOf(group, image, mode, exposure) {
    const reference = decoded(group.images.at(-1));
    const shown = modeOf(decoded(image), mode);
    const key = shown === "image" ? `image ${exposure}` : shown;
    if (!image.bitmaps.has(key)) {
      if (shown === "image") for (const old of image.bitmaps.keys()) if (old.startsWith("image")) image.bitmaps.delete(old);
      const canvas = element("canvas", { width: group.width, height: group.height });
      const context = canvas.getContext("2d");
      const pixels = context.createImageData(group.width, group.height);
      if (shown === "image") fillImage(pixels.data, image.values, 2 ** exposure);
      else fillMap(pixels.data, MODES[shown], image, reference);
      context.putImageData(pixels, 0, 0);
      image.bitmaps.set(key, canvas);
    }
    return image.bitmaps.get(key);
  }

  function fillMap(out, mode, image, reference) {
    const mean = meanOf(reference);
    for (let i = 0, o = 0; i < image.values.length; i += 3, o += 4) {
      const place = Math.min(Math.max(mode.place(image, reference, mean, i), 0), 1);
      out.set(mode.colors[Math.round(255 * place) || 0], o);
      out[o + 3] = 255;
    }
  }

  // State.

  const state = {
    group: data.groups[0],
    left: 0,
    right: data.groups.length ? data.groups[0].images.length - 1 : 0,
    layout: "split",
    mode: "image",
    exposure: 0,
    split: 0.5,
    // Factors of light groups.
    factors: new Map(),
    // CSS pixels per image pixel, and position of the upper left corner of the image in its view, in CSS pixels.
    scale: 1,
    x: 0,
    y: 0,
    fitted: true,
    at: null,
  };

  // The page.

  const title = element("h1", {}, data.title);
  const about = element("p", {}, `Made by manylight ${data.version}. Drag to pan, wheel or pinch to zoom, number keys select the left image.`);
  const groupSelect = element("select", { "aria-label": "Scene", onchange: () => chooseGroup(groupSelect.selectedIndex) });
  const leftSelect = element("select", { id: "left", onchange: () => change({ left: leftSelect.selectedIndex }) });
  const rightSelect = element("select", { id: "right", onchange: () => change({ right: rightSelect.selectedIndex }) });
  const buttons = (names, key) =>
    Object.entries(names).map(([value, label]) =>
      element("button", { type: "button", "data-key": key, "data-value": value, onclick: () => change({ [key]: value }) }, label),
    );
  const layouts = buttons({ split: "Split", both: "Side by side" }, "layout");
  const modes = buttons(Object.fromEntries(Object.entries(MODES).map(([k, m]) => [k, m.label])), "mode");
  const exposure = element("input", {
    type: "range", id: "exposure", min: -8, max: 8, step: 0.25, value: 0,
    oninput: () => change({ exposure: Number(exposure.value) }),
  });
  const exposureText = element("output", {}, "0");
  const fitButton = element("button", { type: "button", onclick: () => { state.fitted = true; draw(); } }, "Fit");
  const fullButton = element("button", { type: "button", onclick: () => zoomMiddle(1 / devicePixelRatio) }, "1:1");
  const bar = element("div", { class: "bar" },
    ...(data.groups.length > 1 ? [element("label", {}, "Scene ", groupSelect)] : []),
    element("label", {}, "Left ", leftSelect),
    element("label", {}, "Right ", rightSelect),
    element("span", {}, ...layouts), element("span", {}, ...modes),
    element("label", {}, "Exposure ", exposure, exposureText),
    element("span", {}, fitButton, fullButton),
  );
  const canvases = [element("canvas"), element("canvas")];
  const tags = [element("div", { class: "tag left" }), element("div", { class: "tag right" })];
  const handle = element("div", { class: "handle", role: "slider", tabindex: 0, "aria-label": "Split", "aria-valuemin": 0, "aria-valuemax": 100 });
  const leftView = element("div", { class: "view" }, canvases[0], handle, ...tags);
  const rightView = element("div", { class: "view" }, canvases[1]);
  const views = element("div", { class: "views" }, leftView, rightView);
  const lights = element("div");
  const readout = element("span");
  const scale = element("span");
  const status = element("div", { class: "state" }, readout, scale);
  const figures = element("div", { class: "wide", title: "of the lights as rendered" });
  document.body.append(title, about, bar, lights, views, status, figures);
  groupSelect.append(...data.groups.map((group) => element("option", {}, group.title)));

  function chooseGroup(index) {
    const group = data.groups[index];
    const named = (k) => group.images.findIndex((image) => image.name === state.group.images[k].name);
    const left = Math.max(named(state.left), 0);
    const right = named(state.right);
    Object.assign(state, { group, left, right: right < 0 ? group.images.length - 1 : right, fitted: true, at: null, factors: new Map() });
    lights.replaceChildren();
    fillGroup();
    draw();
  }

  function change(changes) {
    Object.assign(state, changes);
    draw();
  }

  /** Sliders for the light groups that any image has. */
  function fillLights() {
    if (lights.hasChildNodes()) return;
    const names = new Set(state.group.images.flatMap((image) => (image.lights ?? []).map(({ name }) => name)));
    if (names.size > 0) lights.append(lightPanel([...names], (factors) => change({ factors })));
  }

  function fillGroup() {
    const names = () => state.group.images.map((image) => element("option", {}, image.name));
    leftSelect.replaceChildren(...names());
    rightSelect.replaceChildren(...names());
    const headings = state.group.figures;
    const measured = state.group.images.filter((image) => image.figures.length);
    const best = headings.map(({ less_is_better }, k) => {
      const values = measured.map((image) => image.figures[k]).filter((v) => v !== null);
      return less_is_better ? Math.min(...values) : Math.max(...values);
    });
    const cell = (image, k) => {
      const value = image.figures[k];
      const isBest = measured.length > 1 && value === best[k];
      return element("td", isBest ? { class: "best" } : {}, value === null ? "–" : figureText(value));
    };
    const row = (image) =>
      element("tr", { onclick: () => change({ left: state.group.images.indexOf(image) }) },
        element("td", {}, image.name), ...headings.map((_, k) => cell(image, k)));
    figures.replaceChildren(element("table", {},
      element("thead", {}, element("tr", {}, element("th", {}, "image"), ...headings.map((h) => element("th", {}, h.name)))),
      element("tbody", {}, ...measured.map(row))));
  }

  function figureText(value) {
    if (value === 0) return "0";
    return Math.abs(value) < 1e-3 ? value.toExponential(2) : value.toPrecision(3);
  }

  // Drawing.

  function draw() {
    const { group, layout, mode } = state;
    const isSplit = layout === "split";
    rightView.hidden = isSplit;
    handle.hidden = !isSplit;
    views.classList.toggle("both", !isSplit);
    (isSplit ? leftView : rightView).append(tags[1]);
    if (state.fitted) fit(state, leftView, group.width, group.height);
    leftSelect.selectedIndex = state.left;
    rightSelect.selectedIndex = state.right;
    exposureText.textContent = signedText(state.exposure);
    for (const button of [...layouts, ...modes]) {
      button.setAttribute("aria-pressed", state[button.dataset.key] === button.dataset.value);
    }
    if (!isLoaded(group)) {
      readout.textContent = "loading …";
      return load(group);
    }
    fillLights();
    figures.classList.toggle("stale", state.factors.size > 0);
    const [left, right] = [group.images[state.left], group.images[state.right]];
    tags[0].textContent = left.name;
    tags[1].textContent = right.name;
    const bitmap = (image) => bitmapOf(group, image, mode, state.exposure);
    const whole = leftView.clientWidth;
    const middle = state.split * whole;
    paint(canvases[0], state, isSplit ? [[bitmap(left), 0, middle], [bitmap(right), middle, whole]] : [[bitmap(left), 0, whole]]);
    if (!isSplit) paint(canvases[1], state, [[bitmap(right), 0, whole]]);
    handle.style.left = `${100 * state.split}%`;
    handle.setAttribute("aria-valuenow", Math.round(100 * state.split));
    read();
    noteView();
  }

  // The state in the address of the page, so that a link restores it.

  const center = () => ({
    x: (leftView.clientWidth / 2 - state.x) / state.scale,
    y: (leftView.clientHeight / 2 - state.y) / state.scale,
  });

  let noting = 0;

  /** Stores the state with a delay, because browsers limit the rate of changes of the address. */
  function noteView() {
    clearTimeout(noting);
    noting = setTimeout(() => history.replaceState(null, "", `#${viewText()}`), 250);
  }

  function viewText() {
    const { group, left, right, layout, mode, exposure, split, fitted, scale } = state;
    const view = { scene: group.title, left: group.images[left].name, right: group.images[right].name, layout, mode, exposure, split: split.toFixed(3) };
    if (!fitted) Object.assign(view, { zoom: scale.toFixed(3), x: center().x.toFixed(1), y: center().y.toFixed(1) });
    return new URLSearchParams(view).toString();
  }

  /** Restores the state from the fragment of an address; unknown or missing parts are ignored. */
  function showView(text) {
    const view = new URLSearchParams(text);
    const group = data.groups.find((g) => g.title === view.get("scene"));
    if (group) state.group = group;
    const images = state.group.images;
    const indexOf = (name, otherwise) => {
      const k = images.findIndex((image) => image.name === name);
      return k < 0 ? otherwise : k;
    };
    const oneOf = (names, name, otherwise) => (names.includes(name) ? name : otherwise);
    const number = (key, least, most, otherwise) => {
      const value = Number.parseFloat(view.get(key));
      return Number.isFinite(value) ? Math.min(Math.max(value, least), most) : otherwise;
    };
    Object.assign(state, {
      left: indexOf(view.get("left"), 0),
      right: indexOf(view.get("right"), images.length - 1),
      layout: oneOf(["split", "both"], view.get("layout"), state.layout),
      mode: oneOf(Object.keys(MODES), view.get("mode"), state.mode),
      exposure: number("exposure", -8, 8, state.exposure),
      split: number("split", 0, 1, state.split),
      fitted: true,
    });
    groupSelect.selectedIndex = data.groups.indexOf(state.group);
    exposure.value = state.exposure;
    fillGroup();
    draw();
    const zoom = number("zoom", LEAST_ZOOM, MOST_ZOOM, 0);
    if (zoom === 0) return;
    // After drawing, because the width of a view depends on the layout.
    const { width, height } = state.group;
    const [x, y] = [number("x", 0, width, width / 2), number("y", 0, height, height / 2)];
    Object.assign(state, {
      scale: zoom,
      x: leftView.clientWidth / 2 - x * zoom,
      y: leftView.clientHeight / 2 - y * zoom,
      fitted: false,
    });
    draw();
  }

  /** Displays the values under the pointer, and the color scale. */
  function read() {
    const { group, mode } = state;
    if (!isLoaded(group)) return;
    const { colors, scale: ends } = MODES[knownMode(mode)];
    if (colors) {
      const stops = [0, 64, 128, 192, 255].map((i) => `rgb(${colors[i].map(Math.round).join(" ")})`);
      scale.replaceChildren(`${ends[0]} `, element("span", { class: "scale", style: `background: linear-gradient(90deg, ${stops.join(",")})` }), ` ${ends[1]}`);
    } else scale.replaceChildren();
    const pixel = pixelAt(state, group.width, group.height);
    if (!pixel) {
      readout.textContent = `${group.width} x ${group.height} pixels, zoom ${(100 * state.scale * devicePixelRatio).toFixed(0)} %  `;
      return;
    }
    const i = 3 * (pixel.row * group.width + pixel.column);
    const reference = decoded(group.images.at(-1));
    const line = (image) => {
      const rgb = [0, 1, 2].map((c) => decoded(image).values[i + c].toPrecision(4).padStart(9)).join(" ");
      const error = image.seen ? `  error ${(100 * relativeError(image.values, reference.values, meanOf(reference), i)).toFixed(1)} %` : "";
      const flip = image.seen && knownMode("flip") === "flip" ? `  FLIP ${(image.seen[i / 3] / 255).toFixed(2)}` : "";
      const bars = modeOf(image, "bars") === "bars" ? `  ${differenceInBars(image, reference, i).toFixed(2)} bars` : "";
      return `${rgb}${error}${flip}${bars}  ${image.name}`;
    };
    readout.textContent = `pixel ${pixel.column}, ${pixel.row}\n${line(group.images[state.left])}\n${line(group.images[state.right])}  `;
  }

  // Pan and zoom.

  function zoomMiddle(wanted) {
    zoomTo(state, wanted, leftView.clientWidth / 2, leftView.clientHeight / 2);
    draw();
  }

  for (const canvas of canvases) panAndZoom(canvas, state, { moved: draw, pointed: read, fit: () => fitButton.click() });

  const splitAt = (split) => change({ split: Math.min(Math.max(split, 0), 1) });
  handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
  handle.addEventListener("pointermove", (event) => {
    if (handle.hasPointerCapture(event.pointerId)) splitAt(placeIn(leftView, event).x / leftView.clientWidth);
  });
  handle.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -0.02, ArrowRight: 0.02 }[event.key];
    if (step) splitAt(state.split + step);
  });
  addEventListener("keydown", (event) => {
    const chosen = Number.parseInt(event.key, 10) - 1;
    if (chosen >= 0 && chosen < state.group.images.length && !event.ctrlKey && !event.metaKey) change({ left: chosen });
  });
  addEventListener("resize", () => state.group && draw());

  // Text below.

  /** Nodes of a text with `code` and **bold** words. */
  function words(text) {
    return text.split(/(`[^`]+`|\*\*[^*]+\*\*)/).map((part) => {
      if (part.startsWith("`")) return element("code", {}, part.slice(1, -1));
      if (part.startsWith("**")) return element("b", {}, part.slice(2, -2));
      return part;
    });
  }

  const BLOCKS = {
    heading: ({ level, text }) => (level > 1 ? element(`h${level}`, {}, ...words(text)) : ""),
    comment: () => "",
    paragraph: ({ text }) => element("p", {}, ...words(text)),
    list: ({ items }) => element("ul", {}, ...items.map((item) => element("li", {}, ...words(item)))),
    table: ({ head, rows }) =>
      element("div", { class: "wide" }, element("table", { class: "text" },
        element("thead", {}, element("tr", {}, ...head.map((name) => element("th", {}, name)))),
        element("tbody", {}, ...rows.map((row) => element("tr", {}, ...row.map(([text, isBest]) =>
          element("td", isBest ? { class: "best" } : {}, ...words(text || "–")))))))),
    plot: (block) => plot(block),
  };

  const LINES = ["#6ab0ff", "#ff9a52", "#6fd08c", "#f2708b", "#c39bff", "#e3c94f", "#5fd3d6", "#b8bec9"];

  function drawn(tag, attributes, ...children) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  }

  /** An SVG diagram of lines over logarithmic axes. */
  function plot({ title, x, y, lines }) {
    const [width, height] = [460, 300];
    const box = { left: 62, right: 330, top: 30, bottom: 255 };
    const points = lines.flatMap((line) => line.points).filter((p) => p[0] > 0 && p[1] > 0);
    const axis = (k, from, to) => {
      const logs = points.map((p) => Math.log10(p[k]));
      const [low, high] = [Math.min(...logs) - 0.05, Math.max(...logs) + 0.05];
      const place = (v) => from + ((Math.log10(v) - low) / (high - low)) * (to - from);
      const ticks = [];
      for (let e = Math.floor(low); e <= high; e++) {
        for (const m of high - low > 2 ? [1] : [1, 2, 5]) {
          const v = m * 10 ** e;
          if (Math.log10(v) >= low && Math.log10(v) <= high) ticks.push(v);
        }
      }
      return { place, ticks };
    };
    const across = axis(0, box.left, box.right);
    const up = axis(1, box.bottom, box.top);
    const text = (words, px, py, anchor) =>
      drawn("text", { x: px, y: py, "text-anchor": anchor, fill: "currentColor", "font-size": 11 }, words);
    const rule = (x1, y1, x2, y2) => drawn("line", { x1, y1, x2, y2, stroke: "var(--line)" });
    const short = (v) => String(Number(v.toPrecision(1)));
    const parts = [text(title, (box.left + box.right) / 2, 16, "middle"), text(x, (box.left + box.right) / 2, height - 8, "middle"), text(y, 6, 20, "start")];
    for (const v of across.ticks) parts.push(rule(across.place(v), box.top, across.place(v), box.bottom), text(short(v), across.place(v), box.bottom + 15, "middle"));
    for (const v of up.ticks) parts.push(rule(box.left, up.place(v), box.right, up.place(v)), text(short(v), box.left - 6, up.place(v) + 4, "end"));
    lines.forEach((line, k) => {
      const color = LINES[k % LINES.length];
      const places = line.points.filter((p) => p[0] > 0 && p[1] > 0).map((p) => [across.place(p[0]), up.place(p[1])]);
      parts.push(drawn("polyline", { points: places.map((p) => p.join(",")).join(" "), fill: "none", stroke: color, "stroke-width": 1.8 }));
      for (const [cx, cy] of places) parts.push(drawn("circle", { cx, cy, r: 2.6, fill: color }));
      const row = box.top + 10 + 17 * k;
      parts.push(drawn("rect", { x: box.right + 12, y: row - 8, width: 14, height: 3, fill: color }), text(line.name, box.right + 32, row - 3, "start"));
    });
    return drawn("svg", { viewBox: `0 0 ${width} ${height}`, class: "plot", role: "img", "aria-label": title }, ...parts);
  }

  document.body.append(element("main", {}, ...data.text.map((block) => BLOCKS[block.kind](block))));

  if (state.group) {
    showView(location.hash.slice(1));
    addEventListener("hashchange", () => showView(location.hash.slice(1)));
  } else {
    for (const part of [bar, views, status]) part.hidden = true;
  }
})();
