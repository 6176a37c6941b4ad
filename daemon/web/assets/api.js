// Requests to the control plane, below /api, with the session as the credential.

/** A request that was refused: the daemon's reason, with its help. */
export class Refused extends Error {
  constructor(status, reason) {
    super(reason?.message ?? `the daemon answers ${status}`);
    this.status = status;
    this.code = reason?.code;
    this.help = reason?.help;
    this.where = reason?.where;
  }
}

/** No daemon answers. */
export class Away extends Error {
  constructor() {
    super("the daemon does not answer");
  }
}

async function ask(method, path, body) {
  const headers = body === undefined ? {} : { "Content-Type": "application/json" };
  let response;
  try {
    response = await fetch(path, { method, headers, body, credentials: "same-origin" });
  } catch {
    throw new Away();
  }
  const text = await response.text();
  let reply = null;
  try {
    reply = text === "" ? null : JSON.parse(text);
  } catch {
    // Some replies are no JSON; none of those is read here.
  }
  if (response.ok) return reply;
  if (response.status === 401) dispatchEvent(new Event("signed-out"));
  throw new Refused(response.status, reply?.error);
}

/** The body of a reply as it is, with its headers. */
export async function bytes(path) {
  let response;
  try {
    response = await fetch(`/api${path}`, { credentials: "same-origin" });
  } catch {
    throw new Away();
  }
  if (response.ok) return { headers: response.headers, buffer: await response.arrayBuffer() };
  if (response.status === 401) dispatchEvent(new Event("signed-out"));
  throw new Refused(response.status, (await response.json().catch(() => null))?.error);
}

/** Path of names, each within its segment. */
export function path(...names) {
  return names.map((name) => `/${encodeURIComponent(name)}`).join("");
}

export const get = (path) => ask("GET", `/api${path}`);
export const remove = (path) => ask("DELETE", `/api${path}`, "");
/** A request as the daemon itself proposes it. */
export const request = (method, path, json) => ask(method, `/api${path}`, json);
/** Sends JSON that is written already, so that 64-bit numbers keep their digits. */
export const post = (path, json = "") => ask("POST", `/api${path}`, json);
export const replace = (path, json) => ask("PUT", `/api${path}`, json);

export const session = {
  look: () => ask("GET", "/session"),
  open: (how) => ask("POST", "/session", JSON.stringify(how)),
  close: () => ask("DELETE", "/session"),
};

/** What a refusal says, and what to do about it, as one text. */
export function told(error) {
  const where = error.where ? `${error.where}: ` : "";
  const help = error.help ? ` — ${error.help}` : "";
  return `${where}${error.message}${help}`;
}
