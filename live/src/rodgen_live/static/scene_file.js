// A file that is chosen, told as text in pieces that the connection takes.

const PIECES = /[^]{1,100000}/gu; // never within a character

export default {
  template: `<input type="file" hidden :accept="ending" @change="chosen" />`,
  props: { ending: String, most: Number },
  methods: {
    // A dialog for files opens by a click alone.
    pick() {
      this.$el.click();
    },
    async chosen() {
      const [file] = this.$el.files;
      if (!file) return;
      const text = await this.text(file);
      this.$el.value = ""; // it can be chosen again
      const pieces = text?.match(PIECES);
      if (!pieces) return this.$emit("refused", {});
      pieces.forEach((piece, at) =>
        this.$emit("piece", { text: piece, last: at + 1 === pieces.length })
      );
    },
    async text(file) {
      if (!file.name.endsWith(this.ending) || file.size > this.most) return undefined;
      try {
        const found = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });
        return found.decode(await file.arrayBuffer());
      } catch {
        return undefined;
      }
    },
  },
};
