/* The controls around the stage: what they show of a state, and what they change. */
(function (viewer) {
  "use strict";

  const { colour, MODES } = viewer;

  function fill(select, entries, chosen) {
    const same =
      select.options.length === entries.length &&
      entries.every(([value, text], i) => {
        const option = select.options[i];
        return option.value === value && option.textContent === text;
      });
    if (!same) select.replaceChildren(...entries.map(([value, text]) => new Option(text, value)));
    select.value = chosen;
  }

  /** Names with the samples behind them, as entries of the choice of an image. */
  function imageEntries(panel) {
    return panel.images.map(({ name, count, spp }) => [
      name,
      `${name} (${count} × ${spp} samples)`,
    ]);
  }

  /** Set a slider, and the number beside it. */
  function setStops(slider, stops) {
    slider.value = stops;
    const sign = stops > 0 ? "+" : "";
    slider.labels[0].querySelector("output").textContent = `${sign}${colour.formatNumber(stops)}`;
  }

  viewer.makeControls = function (app, root) {
    const find = (name) => root.querySelector(`[name="viewer-${name}"]`);
    const [scene, model, a, b] = ["scene", "model", "a", "b"].map(find);
    const [exposure, finer, split] = ["exposure", "finer", "split"].map(find);
    const modes = root.querySelector(".viewer-modes");
    const caption = root.querySelector(".viewer-caption");

    for (const [name, { title, about }] of Object.entries(MODES)) {
      const label = document.createElement("label");
      const radio = document.createElement("input");
      Object.assign(radio, { type: "radio", name: "viewer-mode", value: name });
      label.title = about;
      label.append(radio, title);
      modes.append(label);
    }

    scene.addEventListener("change", () => app.choose(scene.value, app.state.panel.model));
    model.addEventListener("change", () => app.choose(app.state.panel.scene, model.value));
    a.addEventListener("change", () => app.change({ a: a.value }));
    b.addEventListener("change", () => app.change({ b: b.value }));
    exposure.addEventListener("input", () => app.expose(Number(exposure.value)));
    finer.addEventListener("input", () => app.refine(Number(finer.value)));
    split.addEventListener("input", () => app.change({ split: Number(split.value) }));
    root.addEventListener("change", ({ target }) => {
      if (target.name === "viewer-mode") app.change({ mode: target.value });
      if (target.name === "viewer-layout") app.change({ layout: target.value });
    });
    const actions = {
      flip: () => app.flip(),
      "zoom-in": () => app.zoomBy(Math.SQRT2),
      "zoom-out": () => app.zoomBy(Math.SQRT1_2),
      fit: () => app.fit(),
      worst: () => app.findLargest(),
      link: () => app.copyLink(),
      help: () => app.showHelp(),
    };
    for (const [name, act] of Object.entries(actions)) {
      root.querySelector(`[data-action="${name}"]`).addEventListener("click", act);
    }

    return {
      show(state) {
        const { panel } = state;
        const panels = [...app.panels.values()];
        const scenes = new Map(panels.map((one) => [one.scene, one.title]));
        fill(scene, [...scenes], panel.scene);
        const models = panels.filter((one) => one.scene === panel.scene).map((one) => one.model);
        fill(model, models.map((name) => [name, name]), panel.model);
        fill(a, imageEntries(panel), state.a);
        fill(b, imageEntries(panel), state.b);
        root.querySelector(`[name="viewer-mode"][value="${state.mode}"]`).checked = true;
        root.querySelector(`[name="viewer-layout"][value="${state.layout}"]`).checked = true;
        setStops(exposure, state.exposure);
        setStops(finer, state.finer);
        const { map, fixed } = MODES[state.mode];
        finer.closest("label").hidden = !map || fixed;
        caption.textContent = `${panel.title}, ${panel.model}`;
        split.value = state.split;
        split.closest("label").hidden = state.layout !== "split";
      },
    };
  };
})(hasteViewer);
