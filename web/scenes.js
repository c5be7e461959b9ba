// The list of scenes: those of the service, and those that somebody has sent, which can go again.

import { drawChoices } from "./choices.js";
import { element } from "./fields.js";
import { Upload } from "./upload.js";

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
    const options = this.#scenes.map((scene) => ({
      value: scene.name,
      name: called(scene),
      about: scene.sent ? "from a file" : scene.description,
      beside: scene.sent ? this.#remover(scene) : null,
    }));
    drawChoices(this.list, options, shown, (name) => this.open(this.named(name)));
  }

  #remover(scene) {
    const remove = element("button", {
      type: "button", className: "remove", textContent: "×", title: "Remove it from the service",
    });
    remove.setAttribute("aria-label", `Remove ${scene.description}`);
    remove.addEventListener("click", () => this.#remove(scene));
    return remove;
  }

  async #remove({ name }) {
    await this.call(`api/scenes/${encodeURIComponent(name)}`, { method: "DELETE" });
    await this.load();
    this.draw(this.#shown);
    if (name === this.#shown) this.open(this.named(null));
  }
}
