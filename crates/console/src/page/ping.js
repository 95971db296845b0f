// A worker that says once a second that the page lives: timers of a page that nobody sees are slowed down, its are not.

setInterval(() => postMessage(null), 1000);
