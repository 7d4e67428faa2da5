// A recorded run as a page of its own: what is kept in run.js is shown as if a server sent it.

import { createApp } from "vue";
import Plots from "./plots.js";
import Rod from "./rod.js";
import TimeLine from "./timeline.js";
import { hub } from "./hub.js";
import { nearest } from "./rows.js";

const { title, rod, plots, times, ends, data } = window.rodgenRun;
const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)).buffer;

let at = 0; // the sample that is shown

// Shows the message of a number: the first has all that stands, the others a sample each.
const show = (number) => hub.receive(bytes.slice(ends[number], ends[number + 1]));

// Answers what the page asks of a server: the sample nearest to a time, or one some steps on.
function answer({ look, step }) {
  if (step !== undefined) at += step;
  else if (look === null) at = times.length - 1;
  else if (look !== undefined) at = nearest(times, look);
  at = Math.min(Math.max(at, 0), times.length - 1);
  show(at + 1);
}

const shade = (dark) => {
  document.body.classList.toggle("body--dark", dark);
  document.body.classList.toggle("body--light", !dark);
};

const App = {
  components: { Plots, Rod, TimeLine },
  template: `
    <div class="rg-page">
      <header class="rg-bar">
        <h1>{{ title }}</h1>
        <label>speed <select v-model.number="speed" aria-label="speed">
          <option v-for="one in speeds" :value="one">{{ one }} ×</option>
        </select></label>
        <label>view <select v-model="rod.view" aria-label="view">
          <option value="fixed">fixed</option>
          <option value="centre">centre of gravity</option>
          <option value="axes">principal axes</option>
        </select></label>
        <button type="button" @click="turn">light or dark</button>
      </header>
      <main class="rg-left">
        <section class="rg-rod" aria-label="The rod"><Rod class="rg-canvas" v-bind="rod" /></section>
        <TimeLine :speed="speed" recorded ref="line" />
        <Plots :specs="plots" @removed="remove" />
      </main>
    </div>`,
  data: () => ({ title, rod, plots, speed: 1, speeds: [0.01, 0.1, 0.25, 0.5, 1, 2, 5, 10] }),
  mounted() {
    shade(matchMedia("(prefers-color-scheme: dark)").matches);
    hub.connected(answer);
    show(0);
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.$refs.line.play(true);
  },
  methods: {
    turn: () => shade(!document.body.classList.contains("body--dark")),
    remove({ id }) {
      this.plots = this.plots.filter((plot) => plot.id !== id);
    },
  },
};

createApp(App).mount("#app");
