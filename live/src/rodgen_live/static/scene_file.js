// A file that is chosen, told as text.

export default {
  template: `<input type="file" hidden :accept="ending" @change="choose" />`,
  props: { ending: String, most: Number },
  methods: {
    // A dialog for files opens by a click alone.
    pick() {
      this.$el.click();
    },
    async choose() {
      const [file] = this.$el.files;
      if (!file) return;
      const text = await this.text(file);
      this.$el.value = ""; // it can be chosen again
      if (text) this.$emit("chosen", { text });
      else this.$emit("refused", {});
    },
    async text(file) {
      if (!file.name.endsWith(this.ending) || file.size > this.most) return null;
      try {
        const found = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true });
        return found.decode(await file.arrayBuffer());
      } catch {
        return null;
      }
    },
  },
};
