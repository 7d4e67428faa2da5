// The time line: a slider over the samples that are kept, steps to either side, and a loop.

import { act, button, make, placeOf, relabel } from "rodgen-live/dom.js";
import { hub } from "rodgen-live/hub.js";
import { above, multiples, short, written } from "rodgen-live/scales.js";
import { theme } from "rodgen-live/theme.js";

const FONT = "11px Roboto, system-ui, sans-serif";
const EDGE = 7; // pixels beside the line: half of the handle, see page.css
const NEAR = 5; // pixels from a mark that tell it
const [LINE, NUMBERS] = [12, 30]; // pixels from the top: the line, the times below it
const APART = 70; // pixels from one of these to the next, at least

export default {
  template: `
    <div class="rodgen-line" role="group" aria-label="Time line">
      <div class="rodgen-track">
        <canvas ref="track"></canvas>
        <input ref="slider" type="range" step="any" aria-label="Time that is shown"
          @input="drag" @pointermove="tell" @keydown="key" />
      </div>
    </div>`,
  props: { speed: Number, recorded: Boolean }, // recorded: no other run can begin
  mounted() {
    this.loop = { a: null, b: null }; // its ends, where they are chosen, else those of the line [s]
    this.playing = false;
    this.build();
    hub.painters.add(this);
    this.sizes = new ResizeObserver(() => this.draw());
    this.sizes.observe(this.track);
  },
  beforeUnmount() {
    this.sizes.disconnect();
    hub.painters.delete(this);
  },
  methods: {
    build() {
      Object.assign(this, { track: this.$refs.track, slider: this.$refs.slider });
      this.go = button("repeat", "", () => this.play(!this.playing));
      this.now = button("last_page", "To the present (End)", () => this.look(null));
      this.ends = {
        a: button("A", "Loop from here (a)", () => this.choose("a", "b")),
        b: button("B", "Loop up to here (b)", () => this.choose("b", "a")),
      };
      const beside = (...buttons) => make("div", { class: "rodgen-buttons" }, ...buttons);
      const back = button("chevron_left", "A sample back (left arrow)", () => this.step(-1));
      const on = button("chevron_right", "A sample on (right arrow)", () => this.step(1));
      const keep = "Keep each run, to compare with the next";
      this.kept = button("filter_none", keep, () => hub.send({ keep: !hub.past.keeps }));
      const another = "Another run from here; this one is kept";
      const branch = button("call_split", another, () => this.send({ branch: null }));
      const begins = this.recorded ? [] : [this.kept, branch];
      const right = beside(this.ends.a, this.ends.b, this.now, ...begins);
      this.$el.prepend(beside(back, this.go, on));
      this.$el.append(right);
      this.play(false);
    },
    play(playing) {
      this.playing = playing;
      this.before = null; // when it was drawn last, in milliseconds
      this.t = hub.past.place; // the time to show, which may lie between samples
      const label = playing ? "Stop playing" : "Play again what was";
      relabel(this.go, playing ? "stop" : "repeat", label);
      if (playing && !hub.past.back) hub.past.look(this.loop.a ?? hub.past.from);
      hub.repaint();
    },
    look(t) {
      this.play(false);
      hub.past.look(t);
    },
    step(by) {
      this.send({ step: by });
    },
    send(what) {
      this.play(false);
      hub.past.tell(what);
    },
    // An end that is beyond the other moves that out of its way; one that is chosen is let go.
    choose(end, other) {
      this.loop[end] = this.loop[end] === null ? hub.past.place : null;
      const { a, b } = this.loop;
      if (a !== null && b !== null && a >= b) this.loop[other] = null;
      hub.repaint();
    },
    place(t) {
      const { from, to } = hub.past;
      const share = to > from ? Math.min(Math.max((t - from) / (to - from), 0), 1) : 1;
      return EDGE + share * (this.track.clientWidth - 2 * EDGE);
    },
    drag() {
      const t = this.slider.valueAsNumber;
      this.look(t < hub.past.to ? t : null);
    },
    tell(event) {
      const [px] = placeOf(event, this.slider);
      const near = hub.past.marks.filter(([t]) => Math.abs(this.place(t) - px) < NEAR);
      this.slider.title = near.map(([t, what]) => `${what}, t = ${short(t, 6)} s`).join("\n");
    },
    // The slider knows the others by itself.
    key(event) {
      act(event, {
        ArrowLeft: () => this.step(-1),
        ArrowDown: () => this.step(-1),
        ArrowRight: () => this.step(1),
        ArrowUp: () => this.step(1),
        a: () => this.choose("a", "b"),
        b: () => this.choose("b", "a"),
      });
    },
    // From one end of the loop to the other and again, by the clock. True while it plays.
    paint(now, fresh, fully) {
      if (this.playing && !hub.past.back) this.play(false);
      if (this.playing) {
        const { a, b } = this.loop;
        const [from, to] = [a ?? hub.past.from, b ?? hub.past.to];
        this.t += (this.speed * (now - (this.before ?? now))) / 1000;
        this.before = now;
        if (!(this.t >= from && this.t <= to)) this.t = from;
        hub.past.look(this.t);
      }
      if (fresh || fully || this.playing) this.draw();
      return this.playing;
    },
    draw() {
      const [wide, high] = [this.track.clientWidth, this.track.clientHeight];
      if (!(wide > 0)) return;
      const dense = window.devicePixelRatio || 1;
      if (this.track.width !== Math.round(wide * dense)) {
        Object.assign(this.track, { width: Math.round(wide * dense), height: high * dense });
      }
      const context = this.track.getContext("2d");
      context.setTransform(dense, 0, 0, dense, 0, 0);
      context.clearRect(0, 0, wide, high);
      this.line(context, LINE, theme());
      this.times(context, wide, theme());
      this.say();
    },
    line(context, y, colours) {
      const { past } = hub;
      const bar = (from, to, height, colour) => {
        const [left, right] = [this.place(from), this.place(to)];
        context.fillStyle = colour;
        context.fillRect(left, y - height / 2, right - left, height);
      };
      bar(past.from, past.to, 4, colours.axis);
      const { a, b } = this.loop;
      if (a !== b) bar(a ?? past.from, b ?? past.to, 10, colours.axis); // one is chosen
      bar(past.from, past.place, 4, colours.faint);
      context.fillStyle = colours.kick;
      for (const [t] of past.marks) context.fillRect(this.place(t) - 1, y - 8, 2, 16);
    },
    // Round times below the line.
    times(context, wide, colours) {
      const { from, to } = hub.past;
      if (!(to > from)) return;
      const step = above(((to - from) * APART) / Math.max(wide - 2 * EDGE, APART));
      Object.assign(context, { fillStyle: colours.faint, font: FONT, textBaseline: "middle" });
      for (const t of multiples(from, to, step).map((count) => count * step)) {
        const x = this.place(t);
        context.fillRect(x - 0.5, LINE + 4, 1, 4);
        const text = `${written(t, step)} s`;
        const half = context.measureText(text).width / 2;
        context.fillText(text, Math.min(Math.max(x - half, 0), wide - 2 * half), NUMBERS);
      }
    },
    say() {
      const { past } = hub;
      const set = (element, name, value) => {
        if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
      };
      const where = past.back ? "looking back" : "the present";
      set(this.slider, "min", past.from);
      set(this.slider, "max", past.to);
      this.slider.value = past.place;
      set(this.slider, "aria-valuetext", `${short(past.place, 6)} s, ${where}`);
      this.slider.classList.toggle("rodgen-back", past.back);
      for (const [end, button] of Object.entries(this.ends)) {
        const t = this.loop[end];
        set(button, "aria-pressed", t !== null);
        const label = button.getAttribute("aria-label");
        set(button, "title", t === null ? label : `At ${short(t, 6)} s; once more: not chosen`);
      }
      set(this.kept, "aria-pressed", past.keeps);
      this.now.disabled = !past.back;
    },
  },
};
