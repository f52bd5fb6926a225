/* The viewer of a page: its state, what may be done with it, and where that shows. */
(function (viewer) {
  "use strict";

  const { link } = viewer;
  /** Milliseconds after which a view that no longer changes is in the address. */
  const SETTLED = 250;
  /** Milliseconds after which somebody wonders what is going on. */
  const PATIENCE = 150;
  const WAITING = "The pixels are being computed …";
  /** From a pixel's corner to its centre. */
  const HALF = 0.5;

  function makeApp(root, catalogue) {
    const panels = viewer.openCatalogue(catalogue);
    const find = (name) => root.querySelector(`.viewer-${name}`);
    const message = find("message");
    const help = find("help");
    let state = null;
    let images = null;
    let turn = 0;
    let settling = 0;

    const stage = viewer.makeStage(find("stage"), {
      names: [...root.querySelectorAll(".viewer-name")],
      divider: find("divider"),
      cursors: [...root.querySelectorAll(".viewer-cursor")],
    });

    /** Show a state as soon as its images are there; a later state overtakes an earlier one. */
    async function show(wanted) {
      const own = ++turn;
      state = wanted;
      controls.show(state);
      const { panel, mode } = state;
      const waiting = setTimeout(() => (message.textContent ||= WAITING), PATIENCE);
      try {
        const [a, b] = await Promise.all([panel.image(state.a), panel.image(state.b)]);
        await viewer.makeMap(panel, mode, a, b);
        if (viewer.MODES[mode].own) await viewer.makeMap(panel, mode, b, b);
        if (own !== turn) return;
        images = { a, b };
      } catch (error) {
        if (own === turn) message.textContent = String(error.message);
        return;
      } finally {
        clearTimeout(waiting);
        if (message.textContent === WAITING) message.textContent = "";
      }
      stage.paint(state, images);
      readout.show(state, images);
      root.dataset.ready = "true";
    }

    /** Write the view into the address once it rests, without an entry in the history. */
    function settle() {
      clearTimeout(settling);
      settling = setTimeout(() => history.replaceState(null, "", link.format(state)), SETTLED);
    }

    function clampView(wanted) {
      const { panel } = wanted;
      const x = link.clamp(wanted.x, [0, panel.width]);
      const y = link.clamp(wanted.y, [0, panel.height]);
      return { ...wanted, x, y, zoom: link.clamp(wanted.zoom, link.ZOOM) };
    }

    /** The usual view of a panel. */
    function freshState(panel) {
      return {
        panel,
        a: panel.names.find((name) => name !== "truth") ?? "truth",
        b: "truth",
        mode: "image",
        x: panel.width / 2,
        y: panel.height / 2,
        zoom: 1,
        exposure: 0,
        finer: 0,
        layout: "side",
        split: 0.5,
        shown: 0,
        cursor: null,
        held: false,
      };
    }

    const step = (list, current, by) =>
      list[(list.indexOf(current) + by + list.length) % list.length];

    const app = {
      panels,
      get state() {
        return state;
      },
      stage,
      change(changes) {
        message.textContent = "";
        settle();
        return show(clampView({ ...state, ...changes }));
      },
      /** Move the cursor without a trace in the address: it follows the mouse. */
      point(cursor) {
        if (cursor.x === state.cursor?.x && cursor.y === state.cursor?.y) return;
        show({ ...state, cursor });
      },
      moveCursor(right, downwards) {
        const { panel, cursor } = state;
        const from = cursor ?? { x: panel.columns >> 1, y: panel.rows >> 1 };
        const moved = {
          x: link.clamp(from.x + right, [0, panel.columns - 1]),
          y: link.clamp(from.y + downwards, [0, panel.rows - 1]),
        };
        // The first key shows the cursor, and the view follows where it would leave it.
        const next = cursor ? moved : from;
        const seen = stage.panes().every(({ frame }) => {
          const scale = stage.scale(frame);
          const x = Math.abs(next.x + HALF - state.x / panel.block) * scale;
          const y = Math.abs(next.y + HALF - state.y / panel.block) * scale;
          return x < frame.width / 2 && y < frame.height / 2;
        });
        app.change({ cursor: next, ...(seen ? {} : app.centreOn(next)) });
        readout.announce(state, images);
      },
      centreOn: ({ x, y }) => ({
        x: (x + HALF) * state.panel.block,
        y: (y + HALF) * state.panel.block,
      }),
      centre: () => state.cursor && app.change(app.centreOn(state.cursor)),
      /** Go to the pixel that is furthest from zero in the map, or in the relative error. */
      async findLargest() {
        const { panel, a, b } = state;
        const mode = viewer.MODES[state.mode].map ? state.mode : "relative";
        const [first, second] = await Promise.all([panel.image(a), panel.image(b)]);
        await viewer.makeMap(panel, mode, first, second);
        const { values } = viewer.pictureOf(panel, mode, first, second, state).picture;
        const size = (value) => {
          if (Number.isNaN(value)) return Infinity;
          return mode === "relative" ? Math.abs(value) : value;
        };
        let largest = 0;
        values.forEach((value, i) => {
          if (size(value) > size(values[largest])) largest = i;
        });
        const cursor = { x: largest % panel.columns, y: Math.floor(largest / panel.columns) };
        app.change({ cursor, ...app.centreOn(cursor) });
        readout.announce(state, images);
      },
      zoomBy(factor) {
        const zoom = link.clamp(state.zoom * factor, link.ZOOM);
        app.change({ zoom, ...(state.cursor && factor > 1 ? app.centreOn(state.cursor) : {}) });
      },
      fit() {
        const { panel } = state;
        app.change({ zoom: 1, x: panel.width / 2, y: panel.height / 2 });
      },
      expose: (stops) => app.change({ exposure: link.clamp(stops, link.STOPS) }),
      refine: (stops) => app.change({ finer: link.clamp(stops, link.STOPS) }),
      moveDivider(by) {
        app.change({ layout: "split", split: link.clamp(state.split + by, [0, 1]) });
      },
      /** Show the other image; panes beside each other give way to one first. */
      flip() {
        const shown = state.layout === "flip" ? 1 - state.shown : 1;
        app.change({ layout: "flip", shown });
      },
      /** While held, each pane shows the other side. */
      hold(held) {
        if (state && held !== state.held) show({ ...state, held });
      },
      /** Another scene or model, with the same images and the same view where they exist. */
      choose(scene, model) {
        const same = [...panels.values()].filter((one) => one.scene === scene);
        const panel = panels.get(`${scene}/${model}`) ?? same[0];
        const { a, b, cursor, ...rest } = { ...state, panel };
        const usual = freshState(panel);
        const sameSize = panel.width === state.panel.width && panel.height === state.panel.height;
        app.change({
          ...rest,
          a: panel.names.includes(a) ? a : usual.a,
          b: panel.names.includes(b) ? b : usual.b,
          cursor: sameSize ? cursor : null,
          ...(sameSize ? {} : { x: usual.x, y: usual.y, zoom: 1 }),
        });
      },
      stepScene(by) {
        const scenes = [...new Set([...panels.values()].map((panel) => panel.scene))];
        app.choose(step(scenes, state.panel.scene, by), state.panel.model);
      },
      stepModel(by) {
        const { scene, model } = state.panel;
        const same = [...panels.values()].filter((panel) => panel.scene === scene);
        app.choose(scene, step(same.map((panel) => panel.model), model, by));
      },
      stepImage: (side, by) => app.change({ [side]: step(state.panel.names, state[side], by) }),
      stepLayout: () => app.change({ layout: step(link.LAYOUTS, state.layout, 1) }),
      async copyLink() {
        const address = location.href.split("#")[0] + link.format(state);
        history.replaceState(null, "", link.format(state));
        try {
          await navigator.clipboard.writeText(address);
          message.textContent = "The link is copied.";
        } catch {
          message.textContent = "The link is in the address bar.";
        }
      },
      showHelp: () => help.showModal(),
    };

    const bringIntoView = () =>
      find("stage").scrollIntoView({ block: "center", behavior: "instant" });

    /** Go where the address says; true if it says so. */
    function follow() {
      const found = link.parse(location.hash, panels, catalogue);
      if (!found) return false;
      const usual = freshState(found.state?.panel ?? state?.panel ?? first);
      message.textContent = found.problem;
      show(clampView({ ...usual, ...(found.state ?? state ?? {}) })).then(bringIntoView);
      return true;
    }

    const first = panels.values().next().value;
    const readout = viewer.makeReadout(root);
    const controls = viewer.makeControls(app, root);
    viewer.listenToPointer(app, stage);
    viewer.listenToKeyboard(app, root, stage);
    new ResizeObserver(() => images && stage.paint()).observe(stage.element);
    window.addEventListener("hashchange", follow);
    // The address does not change where a link is followed twice.
    document.addEventListener("click", ({ target }) => {
      if (target.closest('a[href^="#view="]')?.hash === location.hash) follow();
    });
    if (!follow()) show(freshState(first));
    // What follows the viewer in the page is not there yet, and moves it.
    else window.addEventListener("load", bringIntoView);
    return app;
  }

  const root = document.getElementById("viewer");
  const catalogue = JSON.parse(root.querySelector(".viewer-catalogue").textContent);
  if (catalogue.panels.length) {
    viewer.luminanceWeights = catalogue.luminance;
    viewer.maps = Object.fromEntries(
      Object.entries(catalogue.maps).map(([name, text]) => [name, viewer.colour.readMap(text)])
    );
    viewer.app = makeApp(root, catalogue);
  }
})(hasteViewer);
