// Keys of the whole page.

// Where something is typed or chosen, keys are for that; the space bar is for what it presses. What
// was clicked by the pointer is not pressed: Quasar puts the focus upon something in it.
const TYPED =
  "input:not([type=range]),textarea,select,[contenteditable=true],[role=listbox],[role=menu],[role=dialog]";
const PRESSED = "button,a[href],[role=button],[role=tab],[role=switch],[role=checkbox]";

const taken = (key, target) =>
  target.closest?.(TYPED) || (key === " " && target.matches?.(PRESSED));

// A key by its name, with the modifiers of a shortcut before it: "Ctrl+Shift+z".
function named({ key, ctrlKey, metaKey, shiftKey }) {
  if (!ctrlKey && !metaKey) return key;
  return `Ctrl+${shiftKey ? "Shift+" : ""}${key.toLowerCase()}`;
}

export default {
  template: "<div hidden></div>",
  props: { keys: Array, held: Array },
  mounted() {
    document.addEventListener("keydown", this.press);
  },
  beforeUnmount() {
    document.removeEventListener("keydown", this.press);
  },
  methods: {
    press(event) {
      const { target } = event;
      const key = named(event);
      if (event.altKey || event.defaultPrevented) return;
      if (!this.keys.includes(key) || taken(key, target)) return;
      event.preventDefault(); // the space bar would scroll
      if (!event.repeat || this.held.includes(key)) this.$emit("key", { key });
    },
  },
};
