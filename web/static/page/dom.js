// Makes elements. Every text goes in as a text node: nothing the service says is ever read as markup.

const SVG = "http://www.w3.org/2000/svg";

export function el(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...present(children));
  return node;
}

export function replace(container, ...children) {
  container.replaceChildren(...present(children));
}

// Replaces those children that look different, so that focus, selection and hover survive a refresh. For content whose
// listeners depend on nothing but what is shown.
export function show(container, ...children) {
  const next = [...el("div", {}, ...children).childNodes];
  const now = [...container.childNodes];
  next.forEach((child, at) => {
    if (!now[at]) container.append(child);
    else if (!now[at].isEqualNode(child)) now[at].replaceWith(child);
  });
  for (const gone of now.slice(next.length)) gone.remove();
}

function present(children) {
  return children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false);
}
