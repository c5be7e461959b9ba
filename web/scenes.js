// The list of scenes: those of the service, and those that somebody has sent, which can go again.

import { element } from "./fields.js";
import { Upload } from "./upload.js";

// One of several to choose from.
export function choice(name, text, chosen) {
  const button = element("button", { type: "button" });
  button.setAttribute("role", "radio");
  button.setAttribute("aria-checked", String(chosen));
  button.append(element("b", { textContent: name }), element("small", { textContent: text }));
  return button;
}

// What people call a scene.
export const called = ({ name, description, sent }) => (sent ? description : name);

export class Scenes {
  #scenes = [];
  #shown = null;

  // call(path, options) asks the service, open(scene) shows a scene, of which `draw` hears then.
  constructor(find, { call, open }) {
    Object.assign(this, { list: find("scenes"), call, open });
    this.upload = new Upload(find, async (scene) => {
      await this.load();
      this.draw(this.#shown);
      this.open(scene);
    });
  }

  async load() {
    this.#scenes = await this.call("api/scenes");
  }

  // The scene of a name, or the default one.
  named(name) {
    return this.#scenes.find((scene) => scene.name === name) ?? this.#scenes.find((scene) => scene.default);
  }

  // `shown` is the name of the scene that is open.
  draw(shown) {
    this.#shown = shown;
    this.list.replaceChildren(...this.#scenes.map((scene) => this.#row(scene)));
  }

  #row(scene) {
    const { name, description, sent } = scene;
    const button = choice(called(scene), sent ? "from a file" : description, name === this.#shown);
    button.addEventListener("click", () => this.open(scene));
    if (!sent) return button;
    const remove = element("button", {
      type: "button", className: "remove", textContent: "×", title: "Remove it from the service",
    });
    remove.setAttribute("aria-label", `Remove ${description}`);
    remove.addEventListener("click", () => this.#remove(scene));
    const row = element("div", { className: "sent" });
    row.append(button, remove);
    return row;
  }

  async #remove({ name }) {
    await this.call(`api/scenes/${encodeURIComponent(name)}`, { method: "DELETE" });
    await this.load();
    this.draw(this.#shown);
    if (name === this.#shown) this.open(this.named(null));
  }
}
