// A worker that reports every second that the page is open. A browser slows down timers of hidden pages, but not of
// workers.

setInterval(() => postMessage(null), 1000);
