// The connection to the run: receives states and rows of plots, answers when they are drawn.

import { hub } from "rodgen-live/hub.js";

const FIRST = 1000;
const LONGEST = 5000;

export default {
  template: "<div hidden></div>",
  props: { address: String },
  mounted() {
    this.wait = FIRST;
    this.open();
  },
  beforeUnmount() {
    this.gone = true;
    clearTimeout(this.again);
    this.socket?.close();
  },
  watch: {
    address() {
      clearTimeout(this.again);
      this.wait = FIRST;
      this.open();
    },
  },
  methods: {
    open() {
      this.socket?.close();
      const url = new URL(this.address, window.location.href);
      url.protocol = window.location.protocol === "https:" ? "wss:" : "ws:";
      const socket = new WebSocket(url);
      socket.binaryType = "arraybuffer";
      socket.onopen = () => {
        this.wait = FIRST;
        hub.connected((text) => socket.readyState === WebSocket.OPEN && socket.send(text));
      };
      socket.onmessage = (event) => {
        if (event.data instanceof ArrayBuffer) hub.receive(event.data);
      };
      socket.onclose = () => this.closed(socket);
      this.socket = socket;
    },
    closed(socket) {
      if (socket !== this.socket || this.gone) return;
      hub.connected(null);
      this.again = setTimeout(() => this.open(), this.wait);
      this.wait = Math.min(1.5 * this.wait, LONGEST);
    },
  },
};
