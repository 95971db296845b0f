"""Computes the envelope of talk.wav, independently of Sinew: the rectified sound, smoothed by a Gaussian of 30 ms, every
10 ms. Standard library and NumPy. Run in this folder: python3 envelope.py > envelope.csv

talk.wav is espeak-ng 1.51: espeak-ng -v en -s 150 "Hello. I am a face made of wood and wire, and I can talk to you.",
as 8 bit at 8 kHz. rhubarb.json, .tsv, .dat and .xml are by Rhubarb Lip Sync 1.14.0 (with the acoustic and language models of
PocketSphinx 5.1.1) from the same sentence at 22,050 Hz: rhubarb -f FORMAT talk.wav; the folder of the sound was removed.

papagayo.dat is by LipSyncObject.export of Papagayo-NG 17fa36a, for phonemes that were set by hand.
"""

import wave

import numpy as np

SIGMA_S, RATE_HZ = 0.03, 100

with wave.open("talk.wav") as file:
    rate = file.getframerate()
    samples = np.frombuffer(file.readframes(file.getnframes()), np.uint8)
sound = (samples.astype(float) - 128.0) / 128.0
reach = int(4 * SIGMA_S * rate)
kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (SIGMA_S * rate)) ** 2)
envelope = np.convolve(np.abs(sound), kernel / kernel.sum(), "same")[:: rate // RATE_HZ]
for value in envelope:
    print(f"{value:.6f}")
