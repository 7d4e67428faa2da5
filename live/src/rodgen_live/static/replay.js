// A recorded run as a page of its own: what is kept in run.js is shown as if a server sent it.

import { createApp } from "vue";
import Plots from "./plots.js";
import Rod from "./rod.js";
import TimeLine from "./timeline.js";
import { hub } from "./hub.js";
import { lowest } from "./rows.js";

const { title, rod, plots, times, ends, data } = window.rodgenRun;
const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0)).buffer;

// Answers what the page asks of a server: the sample nearest to a time, or one some steps on.
class Player {
  #at = 0;

  begin() {
    hub.connected((text) => this.#answer(JSON.parse(text)));
    this.#show(0);
  }

  #answer({ look, step }) {
    if (step !== undefined) this.#at += step;
    else if (look === null) this.#at = times.length - 1;
    else if (look !== undefined) this.#at = nearest(look);
    this.#at = Math.min(Math.max(this.#at, 0), times.length - 1);
    this.#show(this.#at + 1);
  }

  // The message of this number: the first has all that stands, the others a sample each.
  #show(number) {
    hub.receive(bytes.slice(ends[number], ends[number + 1]));
  }
}

function nearest(t) {
  const after = Math.min(lowest(times, t), times.length - 1);
  return after && t - times[after - 1] < times[after] - t ? after - 1 : after;
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
    new Player().begin();
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
