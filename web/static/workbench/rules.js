// The rule files of one robot, which an operator may change; a change based on an old version is refused.

import { put } from "../page/api.js";
import { el, replace } from "../page/dom.js";
import { deliveryText, ofRobot } from "./of_robot.js";

/** What a robot's files are changed to, and from which version; kept while the page is open, until it is sent. @type {Map<string, {files: Record<string, string>, version: number}>} */
const drafts = new Map();

/** @param {Element} root */
export function mountRules(root) {
  /** @type {string | null} */
  let robot = null;
  /** @type {RuledRobot | null} */
  let ruled = null;
  const choice = el("select", { "aria-label": "Rule file", "data-testid": "rules-file", onchange: drawText });
  const state = el("span", { class: "quiet small", role: "status" });
  const problem = el("div", { role: "alert" });
  const text = el("textarea", { "aria-label": "Rules", "data-testid": "rules-text", rows: 12, spellcheck: "false", oninput: change });
  const caret = el("span", { class: "quiet small", "data-testid": "rules-caret" });
  const comment = el("input", { type: "text", "aria-label": "Comment", placeholder: "Comment", maxlength: 2000 });
  const newName = el("input", { type: "text", "aria-label": "Name of a new file", placeholder: "new_file", pattern: "[a-z][a-z0-9_]*", size: 12 });
  const send = el("button", { class: "primary", onclick: sendAll }, "Send to the robot");
  const remove = el("button", { onclick: removeFile }, "Remove file");
  replace(
    root,
    el("div", { class: "head" }, choice, remove, newName, el("button", { onclick: addFile }, "Add file"), el("span", { class: "spring" }), el("button", { onclick: discard }, "Read again")),
    state,
    problem,
    text,
    caret,
    el("div", { class: "head" }, comment, send),
  );
  for (const type of ["keyup", "click", "focus"]) text.addEventListener(type, drawCaret);

  const known = ofRobot("rules", problem, (/** @type {RuledRobot} */ answer) => {
    const isDrafted = robot !== null && drafts.has(robot) && ruled !== null;
    ruled = answer;
    if (isDrafted) drawState();
    else draw();
  });

  /** The files as they are on the page. */
  const files = () => (robot !== null && drafts.get(robot)?.files) || ruled?.files || {};

  /** @param {Record<string, string>} changed */
  function draft(changed) {
    if (robot === null || ruled === null) return;
    drafts.set(robot, { files: changed, version: drafts.get(robot)?.version ?? ruled.version });
    drawState();
  }

  function draw() {
    const before = choice.value;
    const names = Object.keys(files());
    replace(choice, names.map((name) => el("option", {}, name)));
    if (names.includes(before)) choice.value = before;
    drawText();
    drawState();
  }

  function drawText() {
    text.value = files()[choice.value] ?? "";
    text.disabled = remove.disabled = choice.value === "";
    drawCaret();
  }

  function drawState() {
    if (robot === null || ruled === null) return;
    const { decided_by: by, comment: why } = ruled;
    const sent = `${deliveryText(ruled)}${by ? `; sent by ${by}` : ""}${why ? `, “${why}”` : ""}`;
    replace(state, drafts.has(robot) ? `${sent}; changed here and not sent yet` : sent);
    send.disabled = !drafts.has(robot);
  }

  function drawCaret() {
    const before = text.value.slice(0, text.selectionStart).split("\n");
    replace(caret, text.disabled ? "" : `${choice.value}:${before.length}:${(before.at(-1) ?? "").length + 1}`);
  }

  function change() {
    draft({ ...files(), [choice.value]: text.value });
    drawCaret();
  }

  function addFile() {
    const name = newName.value;
    if (!name || !newName.reportValidity() || name in files()) return;
    draft({ ...files(), [name]: `AGENT ${name};\n` });
    newName.value = "";
    draw();
    choice.value = name;
    drawText();
  }

  function removeFile() {
    draft(Object.fromEntries(Object.entries(files()).filter(([name]) => name !== choice.value)));
    draw();
  }

  function discard() {
    if (robot !== null) drafts.delete(robot);
    return known.load();
  }

  async function sendAll() {
    const name = robot ?? "";
    const changed = drafts.get(name);
    if (changed === undefined) return;
    await known.answer(async () => {
      const answer = await put(known.path(), { files: changed.files, comment: comment.value }, { "if-match": `"${changed.version}"` });
      if (drafts.get(name) === changed) drafts.delete(name);
      comment.value = "";
      return answer;
    }, [send]);
  }

  return {
    /** @param {string | null} name */
    setRobot(name) {
      robot = name;
      ruled = null;
      replace(choice);
      return known.select(name);
    },
    refresh: known.load,
    /** The file and line at the caret, "guard:3"; empty without a file. */
    caret: () => (text.disabled ? "" : `${choice.value}:${text.value.slice(0, text.selectionStart).split("\n").length}`),
    /** Select a rule in its file. @param {string} rule its file and line, "guard:3" */
    showLine(rule) {
      const [file, line] = rule.split(":");
      if (!(file in files())) return;
      choice.value = file;
      drawText();
      const lines = text.value.split("\n");
      const start = lines.slice(0, Number(line) - 1).reduce((sum, one) => sum + one.length + 1, 0);
      text.focus();
      text.setSelectionRange(start, start + (lines[Number(line) - 1] ?? "").length);
      text.scrollTop = (text.scrollHeight / lines.length) * Math.max(0, Number(line) - 4);
      drawCaret();
    },
  };
}
