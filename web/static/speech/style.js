// The diagram's style, fetched once.

import { fetchStyle } from "../page/dom.js";

/** @type {Promise<unknown> | undefined} */
let style;

export const fetchSpeechStyle = () => (style ??= fetchStyle("style/speech.css"));
