// Orders what is in the layers of a drawing, and sets its heights.

/** Orders each layer by the mean place of its neighbours, a few times in both directions. */
export function order(layers) {
  const place = new Map();
  const note = (layer) => layer.forEach((item, at) => place.set(item, (at + 0.5) / layer.length));
  layers.forEach(note);
  for (let round = 0; round < 10; round += 1) {
    for (const layer of turn(layers, round)) {
      const means = new Map(layer.map((item) => [item, mean(item.links.map(({ to }) => place.get(to))) ?? place.get(item)]));
      layer.sort((one, other) => means.get(one) - means.get(other));
      note(layer);
    }
  }
}

/**
 * Sets `y` of everything, in the order of its layer and `gap` apart: as near as can be to where
 * its connections are straight. Returns where each layer begins and ends.
 */
export function level(layers, gap) {
  for (const layer of layers) {
    let y = 0;
    for (const item of layer) {
      item.y = y;
      y += item.height + between(item, gap);
    }
  }
  for (let round = 0; round < 8; round += 1) {
    for (const layer of turn(layers, round)) {
      const wanted = layer.map((item) => mean(item.links.map(({ to, own, theirs }) => to.y + theirs - own)) ?? item.y);
      settle(layer, wanted, gap);
    }
  }
  return layers.map((layer) => [layer[0].y, layer.at(-1).y + layer.at(-1).height]);
}

/**
 * Sets `y` of wires against the flow: straight, below all layers that they pass, and short ones
 * above long ones. `reach`, where each layer begins and ends, grows by them.
 */
export function under(backs, reach, gap) {
  const lists = [...backs.values()].sort((one, other) => one.length - other.length);
  for (const list of lists) {
    const y = Math.max(...list.map(({ index }) => reach[index][1])) + gap / 3;
    for (const { item, index } of list) {
      item.y = y;
      reach[index][1] = y + item.height;
    }
  }
}

const turn = (layers, round) => round % 2 === 0 ? layers : [...layers].reverse();
const mean = (all) => all.length > 0 ? all.reduce((sum, one) => sum + one, 0) / all.length : undefined;
/** Wires stand closer to each other than components. */
const between = (item, gap) => item.id === undefined ? gap / 6 : gap;

/**
 * Least squares under the order of the layer (isotonic regression): what wants the same place
 * shares it, and forms a block.
 */
function settle(layer, wanted, gap) {
  const blocks = [];
  let offset = 0;
  layer.forEach((item, at) => {
    blocks.push({ sum: wanted[at] - offset, count: 1, items: [[item, offset]] });
    offset += item.height + between(item, gap);
    while (blocks.length > 1 && place(blocks.at(-2)) > place(blocks.at(-1))) {
      const last = blocks.pop();
      const into = blocks.at(-1);
      into.sum += last.sum;
      into.count += last.count;
      into.items.push(...last.items);
    }
  });
  for (const block of blocks) for (const [item, down] of block.items) item.y = place(block) + down;
}

const place = ({ sum, count }) => sum / count;
