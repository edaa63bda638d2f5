// Creates elements. Text is inserted as text nodes: nothing the service sends is parsed as markup.

const SVG = "http://www.w3.org/2000/svg";

/**
 * A button submits its form only if its type says so.
 * @template {keyof HTMLElementTagNameMap} Tag
 * @param {Tag} tag @param {Attributes} attributes @param {...Child} children
 */
export function el(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), tag === "button" ? { type: "button", ...attributes } : attributes, children);
}

/** A state in a word, in a tone of `tone()`. @param {string} tone @param {Child} text @param {Attributes} [attributes] */
export const badge = (tone, text, attributes) => el("span", { class: `badge ${tone}`, ...attributes }, text);

/** @param {...Child} children */
export const quiet = (...children) => el("span", { class: "quiet" }, ...children);

/**
 * @template {keyof SVGElementTagNameMap} Tag
 * @param {Tag} tag @param {Attributes} attributes @param {...Child} children
 */
export function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

/** @template {Element} T @param {T} node @param {Attributes} attributes @param {Child[]} children */
function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (typeof value === "function") node.addEventListener(name.slice("on".length), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...flat(children));
  return node;
}

/** @param {Child[]} children @returns {(Node | string)[]} */
function flat(children) {
  return /** @type {any[]} */ (children).flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false);
}

/** @param {Element} container @param {...Child} children */
export function replace(container, ...children) {
  container.replaceChildren(...flat(children));
}

/**
 * Replace only the children that look different, so that focus, selection and hover survive a refresh. For content whose
 * listeners depend on nothing but what is shown.
 * @param {Element} container @param {...Child} children
 */
export function show(container, ...children) {
  const next = [...el("div", {}, ...children).childNodes];
  const current = [...container.childNodes];
  next.forEach((child, index) => {
    if (!current[index]) container.append(child);
    else if (!current[index].isEqualNode(child)) current[index].replaceWith(child);
  });
  for (const surplus of current.slice(next.length)) surplus.remove();
}

/**
 * The page's element with an id, of the class that index.html gives it.
 * @template {HTMLElement} T
 * @param {string} name @param {new () => T} kind @returns {T}
 */
export function byId(name, kind) {
  const node = document.getElementById(name);
  if (!(node instanceof kind)) throw new Error(`no ${kind.name} #${name} on the page`);
  return node;
}

/** The innermost element around an event's target that matches. @param {Event} event @param {string} selector */
export function closest(event, selector) {
  const found = event.target instanceof Element ? event.target.closest(selector) : null;
  return found instanceof HTMLElement || found instanceof SVGElement ? found : null;
}
