// A message of the server: a JSON header, then arrays, each padded to 8 bytes (frames.py).

const TEXT = new TextDecoder();

// {header, arrays: [[name, typed array], ...]}; the arrays are views of the buffer.
export function decode(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(TEXT.decode(new Uint8Array(buffer, 4, size)));
  const arrays = [];
  let at = 4 + size;
  for (const [name, type, count] of header.arrays ?? []) {
    const kind = type === "f8" ? Float64Array : Float32Array;
    const array = new kind(buffer, at, count);
    arrays.push([name, array]);
    at += 8 * Math.ceil(array.byteLength / 8);
  }
  return { header, arrays };
}
