// Where a goal is stated: a sentence that the service says of, as it is typed, what it lacks and how it could go on.

import { post } from "../page/api.js";
import { el, show } from "../page/dom.js";
import { facts } from "../page/format.js";
import { problemBox } from "../page/problem.js";

const QUIET_MS = 120;

export function mountStatement(store, { select, refresh }) {
  const form = document.getElementById("goal-form");
  const text = document.getElementById("goal-text");
  const box = document.getElementById("goal-problem");
  const hint = document.getElementById("goal-hint");
  const offers = mountOffers(text, document.getElementById("goal-offers"), () => check());
  let asked = 0;
  let timer = null;

  async function check() {
    const mine = ++asked;
    const checked = await post("/v1/goals:check", { world: store.get().world, text: text.value }).catch(() => null);
    if (mine !== asked || checked === null) return; // typed on meanwhile, or the badge says that nobody answers
    tell(checked);
    offers.show(document.activeElement === text ? checked.completions : []);
  }

  function tell(checked) {
    const begun = text.value.trim() !== "";
    const said = !begun ? "" : checked.issue ? checked.issue.detail : `understood: ${facts(checked.goals)}`;
    hint.textContent = said;
    hint.className = checked.issue || !begun ? "hint" : "hint good";
  }

  text.addEventListener("input", () => {
    show(box);
    clearTimeout(timer);
    timer = setTimeout(check, QUIET_MS);
  });
  text.addEventListener("focus", check);
  text.addEventListener("blur", () => offers.show([]));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    clearTimeout(timer);
    asked += 1; // what is still being asked of the sentence comes too late
    offers.show([]);
    const button = form.querySelector("button");
    button.disabled = true;
    show(box);
    try {
      const goal = await post("/v1/goals", { world: store.get().world, text: text.value, ...wishes(form) });
      form.reset();
      hint.textContent = "";
      select(goal.id);
      refresh();
    } catch (problem) {
      hint.textContent = "";
      show(box, problemBox({ title: problem.title, message: problem.message }));
      text.focus();
    } finally {
      button.disabled = false;
    }
  });
  return {
    // A place or sample picked elsewhere on the page is written on.
    write(sentence) {
      text.value = sentence;
      text.focus();
      check();
    },
  };
}

// What the operator wishes of the planning beside the goal; what is left empty is left to the service.
function wishes(form) {
  const given = [...form.elements].filter((field) => field.name && field.value !== "" && (field.type !== "checkbox" || field.checked));
  return Object.fromEntries(given.map((field) => [field.name, field.type === "number" ? field.valueAsNumber : field.type === "checkbox" ? true : field.value]));
}

// The list of sentences under the box (the combobox pattern of WAI-ARIA).
function mountOffers(text, list, onTaken) {
  let chosen = -1;
  const options = () => [...list.children];
  const mark = (index) => {
    chosen = index;
    options().forEach((option, at) => option.setAttribute("aria-selected", String(at === index)));
    const option = options()[index];
    if (option) text.setAttribute("aria-activedescendant", option.id);
    else text.removeAttribute("aria-activedescendant");
    option?.scrollIntoView({ block: "nearest" });
  };
  let offered = "";
  const offer = (sentences) => {
    // What is chosen stays so where the same is offered again.
    if (JSON.stringify(sentences) === offered) return;
    offered = JSON.stringify(sentences);
    show(list, sentences.map((sentence, at) => el("li", { role: "option", id: `goal-offer-${at}`, "aria-selected": "false" }, sentence)));
    list.hidden = sentences.length === 0;
    text.setAttribute("aria-expanded", String(sentences.length > 0));
    mark(-1);
  };
  const take = (option) => {
    text.value = option.textContent;
    offer([]);
    text.focus();
    onTaken();
  };
  text.addEventListener("keydown", (event) => {
    const count = options().length;
    if (list.hidden || count === 0) return;
    if (event.key === "ArrowDown") mark((chosen + 1) % count);
    else if (event.key === "ArrowUp") mark((chosen - 1 + count) % count);
    else if (event.key === "Enter" && chosen >= 0) take(options()[chosen]);
    else if (event.key === "Escape") offer([]);
    else return;
    event.preventDefault();
  });
  // Before the box loses the focus, and the list with it.
  list.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    const option = event.target.closest("[role=option]");
    if (option) take(option);
  });
  return { show: offer };
}
