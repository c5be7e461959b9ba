// A button that copies text; where the browser refuses, the text is shown, chosen, to copy by hand.

import { element } from "./fields.js";

const TOLD_MS = 1500;

// text() is what to copy now; a box for it comes after `place`.
export function copyButton(text, place) {
  const button = element("button", { type: "button", textContent: "Copy" });
  button.addEventListener("click", async () => {
    try {
      // Absent on a page that comes neither from this machine nor over HTTPS.
      await navigator.clipboard.writeText(text());
      button.textContent = "Copied";
      setTimeout(() => (button.textContent = "Copy"), TOLD_MS);
    } catch {
      showText(text(), place);
    }
  });
  return button;
}

function showText(text, place) {
  const box = element("textarea", { className: "text", value: text, readOnly: true, rows: 5 });
  box.setAttribute("aria-label", "Text to copy");
  box.addEventListener("blur", () => box.remove());
  place.after(box);
  box.focus();
  box.select();
}
