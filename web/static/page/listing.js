// The newest goals or missions: a page of them is asked for once, and then only those that something has happened to.

import { get, id } from "./api.js";

const PAGE = 50;
const SINGLY = 8; // if more have changed, the page is quicker

export function createListing(name) {
  const stale = new Set();
  let known = { items: [], more: false };
  let wanted = PAGE;
  let whole = true;

  async function page() {
    const { items, next } = await get(`/v1/${name}?limit=${Math.min(wanted, 1000)}`);
    return { items, more: Boolean(next) };
  }

  async function mended(ids) {
    const fresh = await Promise.all(ids.map((one) => one && thereOrNull(`/v1/${name}/${id(one)}`)));
    const now = new Map(fresh.filter(Boolean).map((one) => [one.id, one]));
    const kept = known.items.filter((one) => now.has(one.id) || !ids.includes(one.id)).map((one) => now.get(one.id) ?? one);
    const oldest = known.more ? kept.reduce((least, one) => (one.created_at < least ? one.created_at : least), "~") : "";
    const news = [...now.values()].filter((one) => one.created_at > oldest && !kept.some((other) => other.id === one.id));
    return { items: [...news, ...kept], more: known.more };
  }

  return {
    older() {
      wanted += PAGE;
      whole = true;
    },
    changed: (one) => stale.add(one),
    all: () => (whole = true),
    async fetch() {
      const [ids, all] = [[...stale], whole];
      if (!all && !ids.length) return known;
      stale.clear();
      whole = false;
      try {
        known = all || ids.length > SINGLY ? await page() : await mended(ids);
      } catch (problem) {
        whole = true;
        throw problem;
      }
      return known;
    },
  };
}

// What may have been deleted since: null then.
export function thereOrNull(path) {
  return get(path).catch((problem) => {
    if (problem.status === 404) return null;
    throw problem;
  });
}
