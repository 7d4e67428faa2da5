// The rod, drawn live: a canvas that shows the newest state of the channel.

import { save } from "rodgen-live/files.js";
import { hub } from "rodgen-live/hub.js";
import { Picture } from "rodgen-live/picture.js";
import { Pointer } from "rodgen-live/rod_pointer.js";

export default {
  template: `
    <div class="rodgen-rod">
      <canvas ref="canvas" role="img" tabindex="0" :aria-label="label"></canvas>
    </div>`,
  props: {
    show: Object,
    view: String,
    support: String,
    clampAngle: Number,
    kick: Boolean,
    perMetre: Number,
    label: String,
    rod: Number,
  },
  mounted() {
    const picture = new Picture(this.$refs.canvas, hub.rod);
    const pointer = new Pointer(
      picture,
      () => hub.repaint(),
      (name, what) => this.$emit(name, what),
    );
    Object.assign(this, { picture, pointer });
    picture.camera.mode = this.view;
    this.set();
    this.painter = { paint: (...frame) => picture.paint(...frame) };
    this.sizes = new ResizeObserver(() => {
      picture.resize();
      // At once: a canvas that was resized is blank.
      picture.draw(performance.now());
    });
    this.sizes.observe(this.$el);
    hub.painters.add(this.painter);
  },
  beforeUnmount() {
    this.sizes.disconnect();
    hub.painters.delete(this.painter);
  },
  watch: {
    show: "set",
    support: "set",
    clampAngle: "set",
    kick: "set",
    perMetre: "set",
    view(mode) {
      this.picture.view(mode);
      hub.repaint();
    },
    rod() {
      this.picture.forget();
      hub.repaint();
    },
  },
  methods: {
    set() {
      const { show, view, support, clampAngle, perMetre } = this;
      const options = { show: { ...show }, view, support, clampAngle, perMetre };
      Object.assign(this.picture.options, options);
      this.pointer.kicks = this.kick;
      hub.repaint();
    },
    fit() {
      this.picture.fit();
      hub.repaint();
    },
    reset_scale() {
      this.picture.resetScale();
      hub.repaint();
    },
    png(name) {
      this.$refs.canvas.toBlob((blob) => save(blob, name || "rod.png"));
    },
  },
};
