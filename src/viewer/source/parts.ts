// The list of an atlas' parts. In: its address. Out: names, squares, addresses of archives.

export interface Part {
  name: string;
  /** `empty`: no receiver lies in it. */
  state: "built" | "empty" | "missing";
  /** South-west and north-east corner, m. */
  low: [number, number];
  high: [number, number];
  /** Absolute; none of parts that are not built. */
  archive: string | null;
}

const STATES: readonly unknown[] = ["built", "empty", "missing"] satisfies Part["state"][];

function pair(value: unknown): [number, number] | null {
  const numbers: unknown[] = Array.isArray(value) ? value : [];
  const [x, y] = numbers;
  return typeof x === "number" && typeof y === "number" ? [x, y] : null;
}

/** Archives are where the list says, seen from it, and on the web only. */
function partOf(value: unknown, list: string): Part | null {
  if (typeof value !== "object" || value === null) return null;
  const { name, state, low, high, archive } = value as Record<string, unknown>;
  const [from, to] = [pair(low), pair(high)];
  if (typeof name !== "string" || !STATES.includes(state) || !from || !to) return null;
  const address = typeof archive === "string" ? new URL(archive, list) : null;
  if (address && !/^https?:$/.test(address.protocol)) return null;
  return { name, state: state as Part["state"], low: from, high: to, archive: state === "built" && address ? address.href : null };
}

export async function readParts(address: string): Promise<Part[]> {
  const list = new URL(address, document.baseURI).href;
  const answer = await fetch(list);
  if (!answer.ok) throw new Error(`${list}: the server answers ${answer.status}`);
  const read: unknown = await answer.json();
  const listed: unknown = typeof read === "object" && read !== null && "parts" in read ? read.parts : null;
  const parts = Array.isArray(listed) ? listed.map((part) => partOf(part, list)) : [];
  if (parts.length === 0 || parts.includes(null)) throw new Error(`${list} is not a list of the parts of an atlas`);
  return parts as Part[];
}
