// The form that states a goal: as a sentence is typed, the service says what is missing and how it could continue.

import { post, problemOf } from "../page/api.js";
import { byId, closest, el, show } from "../page/dom.js";
import { facts } from "../page/format.js";
import { problemBox } from "../page/problem.js";
import { termItems } from "./terms.js";

const QUIET_MS = 120;

/** @param {Store} store @param {{select: (goalId: string) => void, refresh: () => void}} actions */
export function mountGoalForm(store, { select, refresh }) {
  const form = byId("goal-form", HTMLFormElement);
  const button = byId("goal-submit", HTMLButtonElement);
  const text = byId("goal-text", HTMLInputElement);
  const box = byId("goal-problem", HTMLElement);
  const hint = byId("goal-hint", HTMLElement);
  const terms = byId("goal-terms", HTMLElement);
  const showOffers = mountOffers(text, byId("goal-offers", HTMLElement), () => check());
  let requests = 0;
  /** @type {number | undefined} */
  let timer;

  async function check() {
    const number = ++requests;
    /** @type {CheckedSentence | null} */
    const checked = await post("/v1/goals:check", { world: store.get().world, text: text.value }).catch(() => null);
    if (number !== requests || checked === null) return; // the text has changed, or the badge shows that the service is unavailable
    const isEmpty = text.value.trim() === "";
    hint.textContent = isEmpty ? "" : checked.issue ? checked.issue.detail : `understood: ${facts(checked.goals) || "places are kept empty"}`;
    hint.className = checked.issue || isEmpty ? "hint" : "hint good";
    showTerms(isEmpty ? [] : termItems(checked));
    showOffers(document.activeElement === text ? checked.completions : []);
  }

  /** @param {Element[]} items */
  function showTerms(items) {
    show(terms, items);
    terms.hidden = items.length === 0;
  }

  text.addEventListener("input", () => {
    show(box);
    clearTimeout(timer);
    timer = setTimeout(check, QUIET_MS);
  });
  text.addEventListener("focus", check);
  text.addEventListener("blur", () => showOffers([]));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    clearTimeout(timer);
    requests += 1; // ignore the answers to checks under way
    showOffers([]);
    button.disabled = true;
    show(box);
    try {
      const goal = await post("/v1/goals", { world: store.get().world, text: text.value, ...options(form) });
      form.reset();
      hint.textContent = "";
      showTerms([]);
      select(goal.id);
      refresh();
    } catch (error) {
      hint.textContent = "";
      show(box, problemBox(problemOf(error).withoutChoices())); // the choices are offered beneath the text already
      text.focus();
    } finally {
      button.disabled = false;
    }
  });
  return {
    /** Continue with a sentence made elsewhere on the page. @param {string} sentence */
    write(sentence) {
      text.value = sentence;
      text.focus();
      check();
    },
  };
}

/** The planning options that are filled in; the service has defaults for the others. @param {HTMLFormElement} form */
function options(form) {
  const fields = [...form.elements].filter((field) => field instanceof HTMLInputElement || field instanceof HTMLSelectElement);
  const given = fields.filter((field) => field.name && field.value !== "");
  return Object.fromEntries(given.map((field) => [field.name, field.type === "number" ? Number(field.value) : field.value]));
}

/**
 * The list of sentences under the text box (the combobox pattern of WAI-ARIA).
 * @param {HTMLInputElement} text @param {HTMLElement} list @param {() => void} onTaken
 */
function mountOffers(text, list, onTaken) {
  let marked = -1;
  let offered = "";
  const items = () => [...list.children];
  /** @param {number} index */
  const mark = (index) => {
    marked = index;
    items().forEach((item, position) => item.setAttribute("aria-selected", String(position === index)));
    const item = items()[index];
    if (item) text.setAttribute("aria-activedescendant", item.id);
    else text.removeAttribute("aria-activedescendant");
    item?.scrollIntoView({ block: "nearest" });
  };
  /** @param {string[]} sentences */
  const offer = (sentences) => {
    // The mark stays where the same sentences are offered again.
    if (JSON.stringify(sentences) === offered) return;
    offered = JSON.stringify(sentences);
    show(list, sentences.map((sentence, index) => el("li", { role: "option", id: `goal-offer-${index}`, "aria-selected": "false" }, sentence)));
    list.hidden = sentences.length === 0;
    text.setAttribute("aria-expanded", String(sentences.length > 0));
    mark(-1);
  };
  /** @param {Element} item */
  const take = (item) => {
    text.value = item.textContent ?? "";
    offer([]);
    text.focus();
    onTaken();
  };
  text.addEventListener("keydown", (event) => {
    const count = items().length;
    if (list.hidden || count === 0) return;
    if (event.key === "ArrowDown") mark((marked + 1) % count);
    else if (event.key === "ArrowUp") mark((marked - 1 + count) % count);
    else if (event.key === "Enter" && marked >= 0) take(items()[marked]);
    else if (event.key === "Escape") offer([]);
    else return;
    event.preventDefault();
  });
  // `pointerdown`, for a click would come after the text box has lost the focus and closed the list.
  list.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    const item = closest(event, "[role=option]");
    if (item) take(item);
  });
  return offer;
}
