// The connection to the run: receives states and rows of plots, answers when they are drawn.

import { hub } from "rodgen-live/hub.js";

const AGAIN = 2000; // milliseconds from one try to the next

export default {
  template: "<div hidden></div>",
  props: { address: String },
  mounted() {
    this.open();
  },
  beforeUnmount() {
    this.close();
  },
  watch: { address: "open" },
  methods: {
    close() {
      clearTimeout(this.again);
      const { socket } = this;
      this.socket = null;
      socket?.close();
    },
    open() {
      this.close();
      const url = new URL(this.address, window.location.href);
      url.protocol = window.location.protocol === "https:" ? "wss:" : "ws:";
      const socket = new WebSocket(url);
      socket.binaryType = "arraybuffer";
      socket.onopen = () => hub.connected((what) => socket.send(JSON.stringify(what)));
      socket.onmessage = ({ data }) => hub.receive(data);
      socket.onclose = () => {
        if (socket !== this.socket) return;
        hub.connected(null);
        this.again = setTimeout(() => this.open(), AGAIN);
      };
      this.socket = socket;
    },
  },
};
