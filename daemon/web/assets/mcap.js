// Reads the tracks of changes of a recording that genomd wrote, in the browser: the file is sent
// nowhere. Recordings of genomd are not compressed, and their tracks are JSON.

/** What is read: activities, exceptions and changes. */
const TRACKS = new Set(["/genom/activities", "/genom/exceptions", "/genom/changes"]);
const MAGIC = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
/** Largest record, and bytes that are read at once. */
const LARGEST = 512 << 20;
const AT_ONCE = 4 << 20;
/** Most changes of a file. */
const MOST = 200000;

const [FOOTER, CHANNEL, MESSAGE, CHUNK, DATA_END] = [0x02, 0x04, 0x05, 0x06, 0x0f];

/** Why a file is not shown. */
export class NoRecording extends Error {}

/** A place in a file of which some bytes are in memory. */
class Reader {
  #bytes = new DataView(new ArrayBuffer(0));
  #start = 0;

  constructor(file) {
    this.file = file;
    this.at = 0;
  }

  /** The next bytes, as a view; `null` beyond the end. */
  async next(length) {
    if (this.at + length > this.file.size) return null;
    const begin = this.at - this.#start;
    if (begin < 0 || begin + length > this.#bytes.byteLength) {
      const end = Math.min(this.file.size, this.at + Math.max(length, AT_ONCE));
      this.#bytes = new DataView(await this.file.slice(this.at, end).arrayBuffer());
      this.#start = this.at;
    }
    const view = new DataView(this.#bytes.buffer, this.at - this.#start, length);
    this.at += length;
    return view;
  }
}

const words = new TextDecoder();

function text(view, at) {
  const length = view.getUint32(at, true);
  if (at + 4 + length > view.byteLength) throw new RangeError("a text is longer than its record");
  return [words.decode(new Uint8Array(view.buffer, view.byteOffset + at + 4, length)), at + 4 + length];
}

const sub = (view, at, length) => new DataView(view.buffer, view.byteOffset + at, length);

/**
 * The changes of a recording, as `{ at, change }` with `at` in seconds, in order of date; and whether
 * the file was whole. `tell` hears how far it is, from 0 to 1.
 */
export async function changes(file, tell) {
  const reader = new Reader(file);
  const magic = await reader.next(MAGIC.length);
  if (!magic || MAGIC.some((byte, at) => magic.getUint8(at) !== byte)) throw new NoRecording("this is no MCAP file");
  const found = [];
  const topics = new Map();
  let whole = false;
  const record = (kind, view) => {
    if (kind === CHANNEL) {
      const [topic, after] = text(view, 4);
      const [encoding] = text(view, after);
      if (TRACKS.has(topic) && encoding === "json") topics.set(view.getUint16(0, true), topic);
    } else if (kind === MESSAGE && topics.has(view.getUint16(0, true)) && found.length < MOST) {
      const change = JSON.parse(words.decode(sub(view, 22, view.byteLength - 22)));
      if (topics.get(view.getUint16(0, true)) === "/genom/exceptions") change.event = "exception";
      found.push({ at: Number(view.getBigUint64(6, true)) / 1e9, change });
    }
  };
  for (;;) {
    tell(reader.at / file.size);
    const head = await reader.next(9);
    if (!head) break;
    const kind = head.getUint8(0);
    const length = Number(head.getBigUint64(1, true));
    if (kind === DATA_END || kind === FOOTER) {
      whole = true;
      break;
    }
    if (kind === 0 || length > LARGEST) break;
    // A recorder that was killed leaves a chunk without its end.
    const cut = reader.at + length > file.size;
    if (cut && kind !== CHUNK) break;
    const view = await reader.next(Math.min(length, file.size - reader.at));
    try {
      if (kind !== CHUNK) record(kind, view);
      else chunk(view, record);
    } catch (error) {
      if (error instanceof NoRecording) throw error;
      break;
    }
    if (cut) break;
  }
  found.sort((one, other) => one.at - other.at);
  return { found, whole, more: found.length >= MOST };
}

/** The records of a chunk, as far as they are there. */
function chunk(view, record) {
  const [compression, after] = text(view, 28);
  if (compression !== "") {
    throw new NoRecording(`its chunks are compressed (${compression}), which those of genomd are not: \`mcap decompress\` makes a file that can be shown`);
  }
  let at = after + 8;
  while (at + 9 <= view.byteLength) {
    const length = Number(view.getBigUint64(at + 1, true));
    if (at + 9 + length > view.byteLength) return;
    record(view.getUint8(at), sub(view, at + 9, length));
    at += 9 + length;
  }
}
