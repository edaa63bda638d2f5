// The service's public HTTP API, as any client sees it. The session cookie says who asks.

const PATIENCE_MS = 20_000; // a connection may die without a word, and what is asked by turns must not wait for it for ever

export class Problem extends Error {
  constructor({ title, detail, status, choices }) {
    super(detail || title || "The service did not say why");
    this.title = title ?? "";
    this.status = status ?? 0;
    this.choices = choices ?? [];
  }
}

export async function get(path) {
  return answer(await reach(path, { headers: { accept: "application/json" }, signal: AbortSignal.timeout(PATIENCE_MS) }));
}

export function post(path, body = {}) {
  return send("POST", path, body);
}

export function put(path, body, headers = {}) {
  return send("PUT", path, body, headers);
}

async function send(method, path, body, more = {}) {
  const headers = {
    ...more,
    "content-type": "application/json",
    accept: "application/json",
    "idempotency-key": randomKey(),
  };
  return answer(await reach(path, { method, headers, body: JSON.stringify(body) }));
}

// The newest items of a list: its first page. What is older is history, not the operator's present.
export async function list(path) {
  return (await get(path)).items;
}

export const id = encodeURIComponent;

async function reach(path, options) {
  try {
    return await fetch(path, { credentials: "same-origin", ...options });
  } catch {
    unreachable();
  }
}

function unreachable() {
  throw new Problem({ title: "The service cannot be reached" });
}

async function answer(response) {
  const body = await response.json().catch((problem) => (problem instanceof SyntaxError ? null : unreachable()));
  if (response.ok) return body;
  throw new Problem({ status: response.status, title: response.statusText, ...(body ?? {}) });
}

export function randomKey() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
