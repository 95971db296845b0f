// Listens to what the page plays: sends the samples of the page's audio contexts through a processor that notes at which
// frame a tone begins and ends, and reads the clocks of the context. It runs before the page's own scripts, and shares
// no code with them.
window.tap = { clicks: [], sounds: [], clocks: [], rate: 0 };
{
  const processor = () => {
    const AUDIBLE = 0.01, LOUD = 0.4, GAP_S = 0.002;
    class Listener extends AudioWorkletProcessor {
      #spans = { clicks: { level: LOUD, first: -1, last: 0 }, sounds: { level: AUDIBLE, first: -1, last: 0 } };
      process([[samples]]) {
        for (const [kind, span] of Object.entries(this.#spans)) {
          samples?.forEach((sample, index) => {
            if (Math.abs(sample) < span.level) return;
            span.last = currentFrame + index;
            if (span.first >= 0) return;
            span.first = span.last;
            this.port.postMessage({ kind, at: span.first / sampleRate });
          });
          if (span.first >= 0 && currentFrame + 128 - span.last > GAP_S * sampleRate) {
            this.port.postMessage({ kind, at: span.first / sampleRate, until: (span.last + 1) / sampleRate });
            span.first = -1;
          }
        }
        return true;
      }
    }
    registerProcessor("listener", Listener);
  };
  const module = `data:text/javascript,${encodeURIComponent(`(${processor})()`)}`;
  const listen = async (source) => {
    const { context } = source;
    await context.audioWorklet.addModule(module);
    const listener = new AudioWorkletNode(context, "listener");
    listener.port.addEventListener("message", ({ data: { kind, at, until } }) => {
      if (until === undefined) window.tap[kind].push([at, null]);
      else window.tap[kind].at(-1)[1] = until;
    });
    listener.port.start();
    connect.call(source, listener);
    // Without an output, the processor would not be called.
    connect.call(listener, context.destination);
    window.tap.rate = context.sampleRate;
    setInterval(() => {
      const { contextTime, performanceTime } = context.getOutputTimestamp();
      window.tap.clocks.push({ now_s: performance.now() / 1000, next_s: context.currentTime, latency_s: context.outputLatency + context.baseLatency,
        context_s: contextTime, heard_s: performanceTime / 1000 });
    }, 50);
  };
  const connect = AudioNode.prototype.connect;
  AudioNode.prototype.connect = function (to, ...more) {
    if (to instanceof AudioDestinationNode && !(this.context instanceof OfflineAudioContext)) listen(this);
    return connect.call(this, to, ...more);
  };
}
