// Three lines for the first visit, until they are put away.

const SEEN = "relight-welcome-seen";

export function welcome(box, close) {
  let seen = false;
  try {
    seen = localStorage.getItem(SEEN) !== null;
  } catch {
    // A browser that keeps nothing shows it again next time.
  }
  box.hidden = seen;
  close.addEventListener("click", () => {
    box.hidden = true;
    try {
      localStorage.setItem(SEEN, "yes");
    } catch {
      // Likewise.
    }
  });
}
