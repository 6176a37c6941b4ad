// The ports of a component: counters of all, and the value and a plot of those that are opened.

import { get, path, post, told } from "./api.js";
import { el, heads, link, name, pageOf, put, text, whyOf } from "./dom.js";
import { Picture, isImage } from "./image.js";
import { Plot } from "./plot.js";
import { tables } from "./table.js";
import { count, frequency, middlewares } from "./units.js";

/** Values that are asked for in a second, as text; plots have every sample. */
const RATE = 10;

/** `component/port/element` in its parts. */
export function parts(address) {
  const [component, port, ...element] = address.split("/");
  return { component, port, element: element.join("/") || undefined };
}

/** `{ node, take(ports), watched() }`; `changed` is called when another set of ports is watched. */
export function ports(component, context, changed) {
  const body = el("tbody");
  const rows = new Map();
  const node = el("div", { class: "wide" }, el("table", { class: "cards", id: "ports" },
    heads(["Port", "Type", "Connected to", "Middleware", "#Samples", "#Rate"]), body));

  function make(port) {
    const cell = (label, extra) => el("td", { "data-label": label, ...extra });
    const row = { connected: cell("Connected to"), backend: cell("Middleware"),
      samples: cell("Samples", { class: "number" }), rate: cell("Rate", { class: "number" }), open: false };
    row.button = el("button", { type: "button", class: "plain toggle", "aria-expanded": "false", onclick: () => toggle(port, row) },
      el("span", { class: `way ${port.direction}` }, port.direction), " ", name(parts(port.address).port + (parts(port.address).element ? `/${parts(port.address).element}` : "")));
    row.node = el("tr", { "data-port": port.address, title: port.doc },
      el("th", { scope: "row" }, row.button), el("td", { "data-label": "Type" }, name(port.type.replace(/^::/, ""))),
      row.connected, row.backend, row.samples, row.rate);
    return row;
  }

  function toggle(port, row) {
    row.open = !row.open;
    row.button.setAttribute("aria-expanded", String(row.open));
    if (!row.open) {
      row.plot?.close();
      row.picture?.close();
      row.plot = row.picture = undefined;
      row.detail.remove();
      changed();
      return;
    }
    row.watch = el("div", { class: "watch" });
    row.detail = el("tr", { class: "detail", "data-detail": port.address }, el("td", { colspan: 6 },
      port.doc && el("p", { class: "doc" }, port.doc),
      el("p", {}, link(whyOf(port.address.split("/").slice(0, 2).join("/")), "Why is it silent?")), row.watch,
      port.direction === "in" && context.may("call") && publisher(port)));
    row.node.after(row.detail);
    fill(port, row, row.detail);
  }

  /** An image is drawn; of other values there are a text, tables and a plot. */
  async function fill(port, row, detail) {
    const { port: own, element } = parts(port.address);
    const at = path("components", component, "ports", own);
    const type = await get(`${at}/type`).catch(() => null);
    if (!row.open || row.detail !== detail) return;
    if (isImage(type?.message?.definition)) {
      row.picture = new Picture(port.address, `${at}/image`, element ? [["element", element]] : []);
      put(row.watch, row.picture.node);
      return;
    }
    row.value = el("pre", { class: "value", tabindex: 0, role: "group", "aria-label": `Value of ${port.address}` }, "no value yet");
    row.tables = el("div", { class: "tables" });
    row.plot = new Plot(port.address, changed);
    put(row.watch, row.value, row.plot.node, row.tables);
    changed();
  }

  function publisher(port) {
    const { port: own, element } = parts(port.address);
    const input = el("textarea", { rows: 1, spellcheck: "false", "aria-label": `Value to publish to ${port.address}, JSON` });
    const reply = el("output", {});
    const form = el("form", { class: "row" }, input, el("button", { type: "submit" }, "Publish"), reply);
    form.onsubmit = async (event) => {
      event.preventDefault();
      try {
        const query = element ? `?element=${encodeURIComponent(element)}` : "";
        await post(path("components", component, "ports", own) + query, input.value);
        put(reply, "published");
      } catch (error) {
        put(reply, el("span", { class: "bad" }, told(error)));
      }
    };
    return form;
  }

  function take(all) {
    const now = performance.now();
    const there = all.map((one) => one.address);
    for (const [address, row] of rows) {
      if (!there.includes(address)) {
        row.node.remove();
        row.detail?.remove();
        row.plot?.close();
        row.picture?.close();
        rows.delete(address);
      }
    }
    for (const port of all) {
      let row = rows.get(port.address);
      if (!row) {
        row = make(port);
        rows.set(port.address, row);
        body.append(row.node);
      }
      const to = port.connected && parts(port.connected);
      put(row.connected, to ? link(pageOf(to.component), name(port.connected)) : port.direction === "in" ? el("span", { class: "soft" }, "nothing") : "");
      put(row.backend, middlewares(port.backend).map((backend) => [name(backend), " "]));
      const samples = port.traffic?.samples;
      const dropped = port.traffic?.dropped;
      put(row.samples, samples === undefined ? "–" : count(samples), dropped > 0 && el("span", { class: "warn" }, ` ${count(dropped)} dropped`));
      row.history = [...(row.history ?? []).filter(([at]) => now - at < 2000), [now, samples ?? 0]];
      const [[begin, first]] = row.history;
      put(row.rate, now - begin > 500 && samples !== undefined ? frequency(1000 * (samples - first) / (now - begin)) : "–");
    }
  }

  function watched() {
    const open = [...rows].filter(([, row]) => row.open && row.plot);
    const values = open.map(([address, row]) => {
      const { port, element } = parts(address);
      const query = element ? `&element=${encodeURIComponent(element)}` : "";
      return {
        path: `${path("components", component, "ports", port)}/stream?rate=${RATE}${query}`,
        hear(value, kind) {
          if (kind !== "value") return;
          put(row.value, text(JSON.stringify(value, null, 2), 4000));
          const lefts = [...row.tables.children].map((one) => one.scrollLeft);
          put(row.tables, tables(value));
          lefts.forEach((left, at) => row.tables.children[at]?.scrollTo({ left }));
        },
      };
    });
    return open.length > 0 ? [...values, plotted(open)] : values;
  }

  /** One stream for all plots, as fine as the finest of them is drawn. */
  function plotted(open) {
    const columns = Math.max(...open.map(([, row]) => row.plot.rate));
    const query = new URLSearchParams([["columns", columns.toFixed(3)]]);
    for (const [address, row] of open) query.append("plot", address.slice(component.length + 1) + row.plot.wanted);
    return {
      path: `${path("components", component)}/plots?${query}`,
      hear(news, kind) {
        if (kind === "plots") news.plots.forEach((one, at) => open[at][1].plot?.begin(one, news.width_ns));
        if (kind === "columns") news.plots.forEach((one) => open[one.plot][1].plot?.add(one, news.skipped));
      },
      ended(reason) {
        open.forEach(([, row]) => row.plot?.fail(reason?.message ?? "the daemon sends no samples"));
      },
    };
  }

  return { node, take, watched, close: () => rows.forEach((row) => {
    row.plot?.close();
    row.picture?.close();
  }) };
}
