//! The host link: a UART whose bytes are transferred by DMA.

use embassy_stm32::Peri;
use embassy_stm32::dma::{
    Channel, InterruptHandler, ReadableRingBuffer, Request, Transfer, TransferOptions,
};
use embassy_stm32::interrupt::typelevel::Binding;
use embassy_stm32::mode::Blocking;
use embassy_stm32::pac::usart::Usart;
use embassy_stm32::usart::{self, RxDma, TxDma, Uart};

use crate::registers;

/// Maximum number of received bytes that wait for the node.
pub(crate) const WAITING: usize = 2048;
/// Maximum number of bytes that are sent at once.
const AT_ONCE: usize = 512;

/// A DMA channel with its request.
pub struct Dma {
    /// The channel.
    pub channel: Channel<'static>,
    /// The request of [`TxDma`] or [`RxDma`].
    pub request: Request,
}

impl Dma {
    /// Creates the DMA for the bytes that a UART receives.
    #[inline]
    pub fn arriving<U: usart::Instance, C: RxDma<U>>(
        channel: Peri<'static, C>,
        irqs: impl Binding<C::Interrupt, InterruptHandler<C>> + 'static,
    ) -> Self {
        let request = channel.request();
        Self { channel: Channel::new(channel, irqs), request }
    }

    /// Creates the DMA for the bytes that a UART sends.
    #[inline]
    pub fn leaving<U: usart::Instance, C: TxDma<U>>(
        channel: Peri<'static, C>,
        irqs: impl Binding<C::Interrupt, InterruptHandler<C>> + 'static,
    ) -> Self {
        let request = channel.request();
        Self { channel: Channel::new(channel, irqs), request }
    }
}

/// Received bytes: a ring buffer that DMA writes without end. No error of the line stops it: codecs detect damaged
/// bytes.
pub(crate) struct Ring(ReadableRingBuffer<'static, u8>);

impl Ring {
    pub(crate) fn new(uart: Usart, dma: Dma, room: &'static mut [u8]) -> Self {
        let options = TransferOptions::default();
        // SAFETY: the address is the UART's data register, and only DMA uses `room`.
        let mut ring = unsafe {
            ReadableRingBuffer::new(dma.channel, dma.request, registers::come(uart), room, options)
        };
        ring.start();
        uart.cr3().modify(|w| w.set_dmar(true));
        Self(ring)
    }

    /// Reads the received bytes, as many as fit. Reads none if unread bytes were overwritten: the frames show that
    /// some are missing.
    pub(crate) fn read(&mut self, into: &mut [u8]) -> usize {
        if let Ok((len, _)) = self.0.read(into) {
            len
        } else {
            self.0.clear();
            0
        }
    }

    /// Discards all received bytes.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

/// The host link.
pub struct Serial {
    registers: Usart,
    _uart: Uart<'static, Blocking>,
    ring: Ring,
    out: Dma,
    sending: Option<Transfer<'static>>,
    room: &'static mut [u8; AT_ONCE],
}

impl Serial {
    /// Creates the link from a started UART and its registers. May be called only once.
    pub fn new(uart: Uart<'static, Blocking>, registers: Usart, come: Dma, out: Dma) -> Self {
        static WAITS: static_cell::ConstStaticCell<[u8; WAITING]> =
            static_cell::ConstStaticCell::new([0; WAITING]);
        static ROOM: static_cell::ConstStaticCell<[u8; AT_ONCE]> =
            static_cell::ConstStaticCell::new([0; AT_ONCE]);
        let ring = Ring::new(registers, come, WAITS.take());
        registers.cr3().modify(|w| w.set_dmat(true));
        Self { registers, _uart: uart, ring, out, sending: None, room: ROOM.take() }
    }

    /// Reads the received bytes, as many as fit.
    pub(crate) fn read(&mut self, into: &mut [u8]) -> usize {
        self.ring.read(into)
    }

    /// Sends as many bytes as there is room for, and returns their number. Sends nothing while a transfer runs.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> usize {
        if bytes.is_empty() || self.is_busy() {
            return 0;
        }
        self.sending = None;
        let mut len = 0;
        for (to, from) in self.room.iter_mut().zip(bytes) {
            *to = *from;
            len += 1;
        }
        let channel: *mut Channel<'static> = &raw mut self.out.channel;
        let bytes = &raw const self.room[..len];
        // SAFETY: the transfer before is finished and dropped; `room` is not touched until this one is finished.
        self.sending = unsafe {
            let (channel, bytes) = (&mut *channel, &*bytes);
            let out = registers::out(self.registers);
            Some(channel.write(self.out.request, bytes, out, TransferOptions::default()))
        };
        len
    }

    /// Returns whether a transfer runs.
    pub(crate) fn is_busy(&mut self) -> bool {
        self.sending.as_mut().is_some_and(Transfer::is_running)
    }

    /// Waits until the last byte has left.
    pub(crate) fn finish(&mut self) {
        while self.is_busy() || !registers::is_sent(self.registers) {}
    }
}
