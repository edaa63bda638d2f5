// Parts of the page that are fetched when they are first needed, and what is drawn once it is opened.

import { Problem } from "./api.js";
import { el, show } from "./dom.js";
import { problemBox } from "./problem.js";

/** By address. @type {Map<string, Promise<void>>} */
const sheets = new Map();

/**
 * A part's modules, once they and its style sheets are there; all are fetched at its first call and, after a failure, at the next.
 * @template T @param {() => Promise<T>} modules @param {...string} styles
 */
export function part(modules, ...styles) {
  /** @type {Promise<T> | null} */
  let fetched = null;
  /** @returns {Promise<T>} */
  const fetchAll = async () => {
    try {
      return (await Promise.all([modules(), ...styles.map(fetchStyle)]))[0];
    } catch {
      fetched = null;
      throw new Problem({ title: "The service cannot be reached", detail: "This part of the page could not be fetched. Try again once the page is live, or reload it." });
    }
  };
  return () => (fetched ??= fetchAll());
}

/** @param {string} name of a file in style/ */
function fetchStyle(name) {
  const sheet = sheets.get(name) ?? new Promise((done, fail) => {
    const link = el("link", { rel: "stylesheet", href: `style/${name}.css`, onload: () => done(undefined), onerror: (/** @type {Event} */ event) => {
      link.remove();
      sheets.delete(name);
      fail(event);
    } });
    document.head.append(link);
  });
  sheets.set(name, sheet);
  return sheet;
}

/**
 * Have a disclosure's content made when it is first opened; after a failure, which is shown, at the next time.
 * @param {HTMLDetailsElement} node @param {() => Child | Promise<Child>} content
 */
export function whenOpened(node, content) {
  const box = el("div");
  let isMade = false;
  node.append(box);
  node.addEventListener("toggle", async () => {
    if (!node.open || isMade) return;
    isMade = true;
    try {
      show(box, await content());
    } catch (error) {
      isMade = false;
      show(box, problemBox(error));
    }
  });
  return node;
}
