// A scene of one's own: chosen with the button, or dropped anywhere on the page.

import { told } from "./status.js";

export class Upload {
  #busy = false;

  // opened(scene) hears of a scene that the service has taken.
  constructor(find, opened) {
    Object.assign(this, {
      opened, button: find("scene-open"), file: find("scene-file"), told: find("scene-told"),
      drop: find("scene-drop"),
    });
    this.button.addEventListener("click", () => this.file.click());
    this.file.addEventListener("change", () => {
      const [chosen] = this.file.files;
      this.file.value = "";
      this.#send(chosen);
    });
    addEventListener("dragover", (event) => this.#over(event));
    addEventListener("dragleave", (event) => {
      if (event.relatedTarget === null) this.drop.hidden = true;
    });
    addEventListener("drop", (event) => {
      if (!this.#over(event)) return;
      this.drop.hidden = true;
      this.#send(event.dataTransfer.files[0]);
    });
  }

  // Whether it is a file that is dragged; the browser would open it in the place of the page.
  #over(event) {
    if (!event.dataTransfer?.types.includes("Files")) return false;
    event.preventDefault();
    this.drop.hidden = false;
    return true;
  }

  async #send(file) {
    if (!file || this.#busy) return;
    this.#busy = this.button.disabled = true;
    try {
      this.#tell(`Sending ${file.name} …`);
      const scene = await posted(file, (part) => {
        this.#tell(part < 1 ? `Sending ${file.name}: ${Math.floor(100 * part)} %` : `Reading ${file.name} …`);
      });
      this.#tell("");
      this.opened(scene);
    } catch (error) {
      this.#tell(error.message, true);
    } finally {
      this.#busy = this.button.disabled = false;
    }
  }

  #tell(text, bad = false) {
    this.told.textContent = text;
    this.told.classList.toggle("bad", bad);
  }
}

// Resolves to the scene as the list has it; moved(part) hears how much of the file is sent.
function posted(file, moved) {
  return new Promise((resolve, reject) => {
    // What `fetch` has sent it does not say.
    const request = new XMLHttpRequest();
    request.open("POST", `api/scenes?name=${encodeURIComponent(file.name.slice(-200))}`);
    request.responseType = "json";
    request.upload.addEventListener("progress", ({ loaded, total }) => moved(loaded / total));
    request.upload.addEventListener("load", () => moved(1));
    request.addEventListener("load", () => {
      if (request.status === 201) resolve(request.response);
      else reject(new Error(request.response ? told(request.response) : `Status ${request.status}`));
    });
    request.addEventListener("error", () => {
      reject(new Error(`${file.name} could not be sent: it is too large, or the service is gone.`));
    });
    request.send(file);
  });
}
