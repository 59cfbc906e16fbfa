"use strict";
(() => {
  const info = JSON.parse(document.getElementById("info").textContent);

  const state = {
    // Name of the chosen layer.
    layer: "image",
    exposure: 0,
    isPaused: false,
    // What has arrived last, without its values; null before the first pass.
    picture: null,
    // Layers of this picture by name: values, values as displayed, bitmap with its exposure.
    layers: new Map(),
    // Factors of light groups, and the image by them once all groups of this picture are here.
    factors: new Map(),
    relit: null,
    // Events that came while the page was paused.
    held: [],
    // Of the connection: "open", "ended" after the final picture, "lost".
    link: "open",
    // Where the image is in its view.
    scale: 1,
    x: 0,
    y: 0,
    fitted: true,
    at: null,
  };

  // The page.

  const layerSelect = element("select", { id: "layer", onchange: () => chooseLayer(layerSelect.value) }, element("option", {}, "image"));
  const exposure = element("input", {
    type: "range", id: "exposure", min: -8, max: 8, step: 0.25, value: 0,
    oninput: () => setExposure(Number(exposure.value)),
  });
  const exposureText = element("output", { for: "exposure" }, "0");
  const pauseButton = element("button", {
    type: "button", id: "pause", "aria-pressed": false, title: "Keep this picture (space); the render goes on", onclick: () => pause(!state.isPaused),
  }, "Pause");
  const fitButton = element("button", { type: "button", onclick: () => { state.fitted = true; draw(); } }, "Fit");
  const fullButton = element("button", { type: "button", onclick: () => zoomMiddle(1 / devicePixelRatio) }, "1:1");
  const bar = element("div", { class: "bar" },
    element("label", {}, "Layer ", layerSelect),
    element("label", {}, "Exposure ", exposure, exposureText),
    element("span", {}, pauseButton),
    element("span", {}, fitButton, fullButton),
  );
  const canvas = element("canvas");
  const above = element("div", { class: "above" }, "waiting for the first pass …");
  const view = element("div", { class: "view" }, canvas, above);
  const lights = element("div");
  const done = element("div");
  const track = element("div", { class: "track" }, done);
  const readout = element("div", { class: "state" });
  const progress = element("p", { class: "progress", id: "progress", role: "status" });
  document.body.append(element("h1", {}, info.title), progress, bar, lights, track, element("div", { class: "views" }, view), readout,
    element("p", {}, `manylight ${info.version}. Drag to pan, wheel or pinch to zoom, number keys choose a layer, space pauses.`));

  // Events.

  let source = null;
  /** End of the address of events with light groups. */
  const LIGHTS = "?lights";

  function connect() {
    source?.close();
    source = new EventSource(`events/${encodeURIComponent(state.layer)}${state.factors.size > 0 ? LIGHTS : ""}`);
    source.addEventListener("picture", (event) => receive(JSON.parse(event.data)));
    source.addEventListener("end", () => {
      source.close();
      state.link = "ended";
      describe();
    });
    // The program sends everything before it ends. If the connection breaks before, the program is gone: nothing to connect to again.
    source.addEventListener("error", () => {
      source.close();
      state.link = "lost";
      describe();
    });
  }

  const isFinal = (picture) => picture.state !== "rendering";
  const isSamePicture = (a, b) => a.passes === b.passes && a.state === b.state;

  function receive(event) {
    if (!state.isPaused) return show(event);
    // A newer picture replaces the one that is held; a picture may come in several events.
    state.held = [...state.held.filter((held) => isSamePicture(held, event)), event];
    describe();
  }

  function show({ values, layer, ...picture }) {
    const last = state.picture;
    const isSame = last && isSamePicture(last, picture);
    if (!isSame) {
      state.layers.clear();
      state.relit = null;
    }
    if (last && (last.width !== picture.width || last.height !== picture.height)) state.fitted = true;
    state.picture = picture;
    const { name, channels } = picture.layers[layer];
    state.layers.set(name, layerOf(channels, valuesOf(values)));
    nameLayers(picture.layers.map((entry) => entry.name));
    if (name === state.layer || !isSame || (state.factors.size > 0 && !state.relit)) draw();
    describe();
  }

  function nameLayers(names) {
    const known = [...layerSelect.options].map((option) => option.value);
    if (known.join("\n") === names.join("\n")) return;
    layerSelect.replaceChildren(...names.map((name) => element("option", { value: name }, name)));
    if (!names.includes(state.layer)) state.layer = names[0];
    layerSelect.value = state.layer;
    const groups = names.map(groupOf).filter((group) => group !== null);
    lights.replaceChildren(...(groups.length > 0 ? [lightPanel(groups, chooseLights)] : []));
  }

  /** The light group of a layer; null for other layers. */
  const groupOf = (layer) => layer.match(/(?:^|\.)Combined_([^.]+)$/)?.[1] ?? null;

  // Layers.

  /** A layer: its values, and the colors that show them before exposure. */
  function layerOf(channels, values) {
    const count = channels.length;
    const isColor = count >= 3 && channels[0] === "R";
    const isDirection = count === 3 && !isColor && values.every((v) => !(Math.abs(v) > 1.001));
    if (isColor && count === 3) return { channels, values, colors: values };
    const colors = new Float32Array((values.length / count) * 3);
    const most = isColor || isDirection ? 1 : highest(values);
    for (let i = 0, o = 0; i < values.length; i += count, o += 3) {
      for (let c = 0; c < 3; c++) {
        const v = values[i + Math.min(c, count - 1)];
        // Directions as in normal maps; the bytes of gray are proportional to the value.
        colors[o + c] = isColor ? v : linear(isDirection ? 0.5 + 0.5 * v : v / most);
      }
    }
    return { channels, values, colors };
  }

  /** The value that exceeds 99 % of a sample of the values in size; 1 if there is none. */
  function highest(values) {
    const step = Math.max(1, Math.floor(values.length / 10000));
    const sizes = [];
    for (let i = 0; i < values.length; i += step) if (Number.isFinite(values[i])) sizes.push(Math.abs(values[i]));
    sizes.sort((a, b) => a - b);
    return sizes[Math.floor(0.99 * (sizes.length - 1))] || 1;
  }

  function bitmapOf(layer) {
    if (layer.exposure !== state.exposure) {
      const { width, height } = state.picture;
      layer.bitmap ??= element("canvas", { width, height });
      const context = layer.bitmap.getContext("2d");
      const pixels = context.createImageData(width, height);
      fillImage(pixels.data, layer.colors, 2 ** state.exposure);
      context.putImageData(pixels, 0, 0);
      layer.exposure = state.exposure;
    }
    return layer.bitmap;
  }

  /** The layer that is displayed: the image by the chosen lights. Undefined while parts of it are missing. */
  function shownLayer() {
    if (state.layer !== layerSelect.options[0].value || state.factors.size === 0) return state.layers.get(state.layer);
    state.relit ??= relitLayer();
    return state.relit ?? undefined;
  }

  function relitLayer() {
    const names = state.picture.layers.map((entry) => entry.name);
    // Groups add up to the image with its noise.
    const sum = state.layers.get(names.find((name) => /(^|\.)noisy$/.test(name)) ?? names[0]);
    const groups = names.filter((name) => groupOf(name) !== null).map((name) => [groupOf(name), state.layers.get(name)]);
    if (!sum || groups.some(([, layer]) => !layer)) return null;
    const colors = relit(sum.colors, groups.map(([name, layer]) => [name, layer.colors]), state.factors);
    return { channels: ["R", "G", "B"], values: colors, colors };
  }

  // What the user does.

  function chooseLights(factors) {
    state.factors = factors;
    state.relit = null;
    if (!shownLayer()) pause(false);
    // The program sends the groups of each picture while they are needed.
    if (state.link === "open" && source.url.endsWith(LIGHTS) !== factors.size > 0) connect();
    draw();
  }

  function chooseLayer(name) {
    state.layer = name;
    layerSelect.value = name;
    if (!state.layers.has(name)) pause(false);
    // All layers of the final picture are here; of another picture, the program sends the chosen one.
    if (!state.layers.has(name) && state.link === "open") connect();
    draw();
  }

  function setExposure(stops) {
    state.exposure = stops;
    exposure.value = stops;
    exposureText.textContent = signedText(stops);
    draw();
  }

  function pause(isPaused) {
    state.isPaused = isPaused;
    pauseButton.setAttribute("aria-pressed", isPaused);
    pauseButton.textContent = isPaused ? "Resume" : "Pause";
    const held = state.held;
    state.held = [];
    held.forEach(show);
    describe();
  }

  function zoomMiddle(wanted) {
    zoomTo(state, wanted, view.clientWidth / 2, view.clientHeight / 2);
    draw();
  }

  panAndZoom(canvas, state, { moved: draw, pointed: read, fit: () => fitButton.click() });
  addEventListener("resize", draw);
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === " " && !["BUTTON", "SELECT"].includes(event.target.tagName)) {
      event.preventDefault();
      return pauseButton.click();
    }
    const option = layerSelect.options[Number.parseInt(event.key, 10) - 1];
    if (option) chooseLayer(option.value);
  });

  // Display.

  function draw() {
    const layer = shownLayer();
    if (!layer) return;
    above.hidden = true;
    const { width, height } = state.picture;
    if (state.fitted) fit(state, view, width, height);
    paint(canvas, state, [[bitmapOf(layer), 0, view.clientWidth]]);
    read();
  }

  /** Shows the values under the pointer. */
  function read() {
    const layer = shownLayer();
    if (!layer) return;
    const { width, height } = state.picture;
    const pixel = pixelAt(state, width, height);
    if (!pixel) {
      readout.textContent = `${width} x ${height} pixels, zoom ${(100 * state.scale * devicePixelRatio).toFixed(0)} %`;
      return;
    }
    const count = layer.channels.length;
    const start = count * (pixel.row * width + pixel.column);
    const values = layer.channels.map((name, c) => `${name} ${layer.values[start + c].toPrecision(4)}`);
    readout.textContent = `pixel ${pixel.column}, ${pixel.row}   ${values.join("  ")}`;
  }

  function timeText(seconds) {
    const whole = Math.round(seconds);
    if (whole < 60) return `${seconds < 10 ? seconds.toFixed(1) : whole} s`;
    const two = (n) => String(n).padStart(2, "0");
    if (whole < 3600) return `${Math.floor(whole / 60)} min ${two(whole % 60)} s`;
    return `${Math.floor(whole / 3600)} h ${two(Math.floor((whole % 3600) / 60))} min`;
  }

  const percentText = (share) => `${(100 * share).toPrecision(2)} %`;

  const LINKS = {
    open: "rendering",
    ended: "done",
    lost: "ended without a final picture",
  };

  /** Describes the picture that is shown, and the state of the render. */
  function describe() {
    const { picture, held, link } = state;
    const parts = [];
    if (picture) {
      parts.push(info.passes ? `pass ${picture.passes} of ${info.passes}` : `pass ${picture.passes}`);
      parts.push(info.seconds ? `${timeText(picture.seconds)} of ${timeText(info.seconds)}` : timeText(picture.seconds));
      if (picture.error !== null) {
        const target = info.error ? ` (target ${percentText(info.error)})` : "";
        parts.push(`error at most ${percentText(picture.error)}${target}`);
      }
    }
    const isDone = picture !== null && isFinal(picture);
    const paused = held.length ? `paused; pass ${held[0].passes} has arrived` : "paused";
    const word = !picture && link === "open" ? "loading" : isDone ? picture.state : LINKS[link];
    const words = state.isPaused ? [...parts, paused] : parts;
    pauseButton.disabled = link !== "open" && !state.isPaused;
    progress.replaceChildren(element("b", { class: link === "lost" && !isDone ? "lost" : "" }, word), ...words.map((text) => ` · ${text}`));
    const shares = picture ? [info.passes && picture.passes / info.passes, info.seconds && picture.seconds / info.seconds] : [];
    const share = isDone ? 1 : Math.min(Math.max(0, ...shares.filter(Boolean)), 1);
    done.style.width = `${100 * share}%`;
    track.classList.toggle("ended", isDone || link !== "open");
    document.title = picture ? `${isDone ? picture.state : parts[0]} - ${info.title}` : info.title;
  }

  describe();
  connect();
})();
