// What the pointer and the keyboard do on the graph: drag an end to another, open menus, walk along
// connections.

/**
 * Pixels after which a press is a drag, and milliseconds after which one with a finger or a pen opens
 * the menu. A mouse has a button for that, and who presses it may wait before dragging.
 */
const MOVES = 5;
const LONG = 500;

/**
 * `acts`: `begin(key)` says from where a drag of this element begins, `{ from, keep }`, or nothing;
 * `over(key | undefined)` hears what is below it, and `drop(key)` where it ends; `click(key)`,
 * `menu(key, pointer)`.
 */
export function pointer(canvas, view, line, acts) {
  const keyAt = (event) => {
    const found = document.elementFromPoint(event.clientX, event.clientY)?.closest?.("#graph [data-key], #graph [data-id]");
    return found?.dataset.key ?? found?.dataset.id;
  };
  let pressed = false;

  canvas.addEventListener("pointerdown", (event) => {
    const key = event.target.closest("[data-key]")?.dataset.key;
    if (!key || event.button !== 0) return;
    const start = { x: event.clientX, y: event.clientY };
    const begun = acts.begin(key, event);
    let drags = false;
    const long = event.pointerType !== "mouse" && setTimeout(() => {
      end();
      pressed = true;
      addEventListener("pointerup", () => setTimeout(() => { pressed = false; }), { once: true });
      acts.menu(key, start);
    }, LONG);
    const move = (now) => {
      if (!drags && Math.hypot(now.clientX - start.x, now.clientY - start.y) < MOVES) return;
      clearTimeout(long);
      if (!drags && begun) acts.over(undefined);
      drags = true;
      if (!begun) {
        view.pan(now.clientX - start.x, now.clientY - start.y);
        [start.x, start.y] = [now.clientX, now.clientY];
        return;
      }
      const [from, to] = begun.backwards ? [view.point(now), begun.at] : [begun.at, view.point(now)];
      line.removeAttribute("hidden");
      line.setAttribute("d", `M${from.x} ${from.y} L${to.x} ${to.y}`);
      acts.over(keyAt(now));
    };
    const end = (now) => {
      clearTimeout(long);
      for (const [kind, act] of all) removeEventListener(kind, act);
      line.setAttribute("hidden", "");
      // What follows a drag is no click.
      pressed = drags;
      if (begun) acts.drop(drags && now?.type === "pointerup" ? keyAt(now) : undefined);
    };
    const all = [["pointermove", move], ["pointerup", end], ["pointercancel", end]];
    for (const [kind, act] of all) addEventListener(kind, act);
    pressed = false;
  });

  canvas.addEventListener("click", (event) => {
    const key = event.target.closest("[data-key]")?.dataset.key;
    if (pressed) event.preventDefault();
    else if (key) acts.click(key, event);
    pressed = false;
  }, true);
  canvas.addEventListener("contextmenu", (event) => {
    event.preventDefault();
    const key = event.target.closest("[data-key]")?.dataset.key;
    if (key && !document.getElementById("menu")) acts.menu(key, { x: event.clientX, y: event.clientY });
  });
}

/** The key to which an arrow leads from `key`, in a drawing; undefined at an end. */
export function next(key, arrow, { nodes, ports, edges }) {
  const step = { ArrowUp: -1, ArrowDown: 1 }[arrow];
  const edgeOf = (end, side) => [...edges.values()].find((one) => (one[side].port ?? one[side].node) === end);
  const stop = ({ node, port }) => port ?? node;
  if (key.startsWith("edge ")) {
    const one = edges.get(key.slice(5));
    if (!one) return undefined;
    if (!step) return stop(arrow === "ArrowRight" ? one.to : one.from);
    const beside = [...edges.values()].filter((other) => stop(other.from) === stop(one.from));
    return stepped(beside.map((other) => `edge ${other.key}`), key, step);
  }
  const side = arrow === "ArrowRight" ? "from" : "to";
  const row = ports.get(key);
  if (!row) {
    const node = nodes.get(key);
    if (!node) return undefined;
    if (step) return step > 0 && !node.folded ? [...node.rows.in, ...node.rows.out][0]?.key : undefined;
    const [edge, rows] = [edgeOf(key, side), arrow === "ArrowRight" ? node.rows.out : node.rows.in];
    return edge ? `edge ${edge.key}` : rows[0]?.key;
  }
  const { node, port } = row;
  const rows = node.rows[port.way];
  if (step) return rows[0].key === key && step < 0 ? node.id : stepped(rows.map((one) => one.key), key, step);
  const inward = (port.way === "in") === (arrow === "ArrowRight");
  if (inward) {
    const across = port.way === "in" ? node.rows.out : node.rows.in;
    return across[Math.min(rows.indexOf(port), across.length - 1)]?.key ?? node.id;
  }
  const edge = edgeOf(key, side);
  return edge && `edge ${edge.key}`;
}

const stepped = (keys, key, step) => keys[keys.indexOf(key) + step];
